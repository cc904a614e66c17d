"""The player of a bag."""

import pytest
from rclpy.qos import DurabilityPolicy, QoSProfile
from rosgraph_msgs.msg import Clock
from std_msgs.msg import String

from shirube_bags.bag_reader import BagMessage, BagReader, BagTopic, jazzy_types
from shirube_bags.bag_writer import BagWriter, reliable_qos
from shirube_bags.errors import ReplayError
from shirube_bags.ros_session import BagPlayer, load_message_class


def text_message(stamp_ns, text):
    types = jazzy_types()
    raw = types.serialize_cdr(types.types['std_msgs/msg/String'](text), 'std_msgs/msg/String')
    return BagMessage('/text', 'std_msgs/msg/String', stamp_ns, bytes(raw))


def test_the_clock_never_goes_back_but_after_a_rewind(ros):
    ticks = []
    node = ros.node('watch')
    node.create_subscription(Clock, '/clock', lambda message: ticks.append(message.clock.sec), 100)
    player = BagPlayer(ros.node('player'), [])
    assert ros.spin_until(lambda: node.count_publishers('/clock') == 1)
    for second in (1, 3, 2, 3, 4):
        player.set_clock(second * 10**9)
    player.rewind()
    player.set_clock(2 * 10**9)
    assert ros.spin_until(lambda: ticks and ticks[-1] == 2)
    assert ticks[-4:] == [1, 3, 4, 2]


def test_a_recorded_clock_is_replayed(ros, tmp_path):
    types = jazzy_types().types
    with BagWriter(tmp_path / 'bag') as bag:
        tick = types['rosgraph_msgs/msg/Clock'](types['builtin_interfaces/msg/Time'](5, 0))
        bag.write('/clock', 'rosgraph_msgs/msg/Clock', tick, 77 * 10**9)
    node, ticks = ros.node('watch'), []
    node.create_subscription(Clock, '/clock', lambda message: ticks.append(message.clock.sec), 10)
    with BagReader(tmp_path / 'bag') as bag:
        player = BagPlayer(ros.node('player'), bag.topics.values())
        assert ros.spin_until(lambda: player.subscriber_count('/clock') == 1)
        for message in bag.messages():
            player.publish(message)
    assert ros.spin_until(lambda: ticks)
    assert ticks == [5]


def test_a_late_subscriber_gets_what_was_latched(ros):
    topic = BagTopic('/text', 'std_msgs/msg/String', 2, (reliable_qos(1, latched=True),))
    player = BagPlayer(ros.node('player'), [topic])
    for text in ('old', 'new'):
        player.publish(text_message(1, text))
    received = []
    latched = QoSProfile(depth=1, durability=DurabilityPolicy.TRANSIENT_LOCAL)
    ros.node('late').create_subscription(String, 'text', lambda text: received.append(text.data), latched)
    assert ros.spin_until(lambda: 'new' in received)


def test_topics_can_be_remapped(ros):
    node = ros.node('player', cli_args=['--ros-args', '-r', '/text:=/words'])
    player = BagPlayer(node, [BagTopic('/text', 'std_msgs/msg/String', 1, ())])
    received = []
    ros.node('ears').create_subscription(String, 'words', lambda message: received.append(message.data), 10)
    assert player.resolve_topic('/text') == '/words'
    assert ros.spin_until(lambda: player.subscriber_count('/text') == 1)
    player.publish(text_message(1, 'hello'))
    assert ros.spin_until(lambda: received == ['hello'])


@pytest.mark.parametrize('msgtype', ['my_msgs/msg/Thing', 'sensor_msgs/msg/Thing', 'std_srvs/srv/Thing_Event'])
def test_an_unknown_type_is_refused_in_one_line(msgtype):
    with pytest.raises(ReplayError, match='not installed; install'):
        load_message_class(msgtype)
