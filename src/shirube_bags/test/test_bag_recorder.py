"""The recorder of live topics."""

import pytest
import rclpy
from builtin_interfaces.msg import Time
from rclpy.qos import (
    DurabilityPolicy,
    HistoryPolicy,
    QoSCompatibility,
    QoSProfile,
    qos_check_compatible,
    qos_profile_sensor_data,
)
from rosbags.interfaces import QosDurability, QosReliability
from rosgraph_msgs.msg import Clock
from std_msgs.msg import Int32, String

from shirube_bags.bag_reader import BagReader, BagTopic
from shirube_bags.bag_writer import BagWriter, reliable_qos
from shirube_bags.errors import ReplayError
from shirube_bags.ros_session import BagRecorder, get_message_class, offered_qos, recording_qos, replay_qos


def record(ros, path, topics, publish, counts):
    """Record until ``counts`` is reached; once the topics are found, ``publish`` is called until it has done so."""
    lines = []
    with BagWriter(path) as bag:
        recorder = BagRecorder(ros.node('recorder'), bag, topics, lines.append)
        assert ros.spin_until(lambda: recorder.find_topics() or (counts.keys() <= recorder.counts.keys() and publish()))
        assert ros.spin_until(lambda: recorder.find_topics() or counts.items() <= recorder.counts.items())
    return recorder, lines


def test_messages_are_read_back_equal_whatever_the_publisher_s_quality(ros, tmp_path):
    node = ros.node('talker')
    reliable = node.create_publisher(String, 'words', 10)
    sensor = node.create_publisher(Int32, 'numbers', qos_profile_sensor_data)

    def publish():
        if not reliable.get_subscription_count() or not sensor.get_subscription_count():
            return False
        for index in range(5):
            reliable.publish(String(data=f'word {index}'))
            sensor.publish(Int32(data=index))
        return True

    record(ros, tmp_path / 'bag', ['/words', 'numbers'], publish, {'/words': 5, '/numbers': 5})
    with BagReader(tmp_path / 'bag') as bag:
        assert [bag.decode(each).data for each in bag.messages(['/words'])] == [f'word {i}' for i in range(5)]
        assert [bag.decode(each).data for each in bag.messages(['/numbers'])] == list(range(5))


def test_all_topics_are_recorded_and_latched_ones_with_what_was_published_before(ros, tmp_path):
    latched = QoSProfile(depth=1, durability=DurabilityPolicy.TRANSIENT_LOCAL)
    ros.node('mapper').create_publisher(String, 'map', latched).publish(String(data='here'))
    recorder, lines = record(ros, tmp_path / 'bag', [], lambda: True, {'/map': 1})
    assert 'recording /map [std_msgs/msg/String]' in lines
    assert '/map' in recorder.counts
    with BagReader(tmp_path / 'bag') as bag:
        assert bag.topics['/map'].qos[0].durability.name == 'TRANSIENT_LOCAL'


def test_messages_from_before_the_first_clock_get_its_time(ros, tmp_path):
    node = ros.node('talker')
    words, clock = node.create_publisher(String, 'words', 10), node.create_publisher(Clock, '/clock', 10)
    simulated = ros.node('recorder', parameter_overrides=[rclpy.Parameter('use_sim_time', value=True)])
    with BagWriter(tmp_path / 'bag') as bag:
        recorder = BagRecorder(simulated, bag, ['/words'], lambda _: None)
        assert ros.spin_until(lambda: recorder.find_topics() or not recorder.missing_topics)
        words.publish(String(data='early'))
        for _ in range(20):
            ros.executor.spin_once(timeout_sec=0.01)
        assert recorder.counts == {'/words': 0}
        clock.publish(Clock(clock=Time(sec=7)))
        assert ros.spin_until(lambda: simulated.get_clock().now().nanoseconds > 0)
        words.publish(String(data='late'))
        assert ros.spin_until(lambda: recorder.counts == {'/words': 2})
    with BagReader(tmp_path / 'bag') as bag:
        found = [(bag.decode(each).data, each.stamp_ns) for each in bag.messages()]
    assert found == [('early', 7 * 10**9), ('late', 7 * 10**9)]


def test_topics_that_nobody_publishes_are_missing(ros, tmp_path):
    with BagWriter(tmp_path / 'bag') as bag:
        recorder = BagRecorder(ros.node('recorder'), bag, ['/nothing'], print)
        recorder.find_topics()
        assert recorder.missing_topics == ['/nothing']


@pytest.mark.parametrize(
    ('types', 'message'),
    [
        (['std_msgs/msg/String', 'std_msgs/msg/Int32'], 'one type per topic'),
        (['my_msgs/msg/Thing'], 'use ros2 bag record'),
    ],
)
def test_what_cannot_be_recorded_is_refused(types, message):
    with pytest.raises(ReplayError, match=message):
        get_message_class('/thing', types)


LATCHED = QoSProfile(depth=3, durability=DurabilityPolicy.TRANSIENT_LOCAL)
RELIABLE = QoSProfile(depth=10)


class Endpoint:
    def __init__(self, qos_profile):
        self.qos_profile = qos_profile


@pytest.mark.parametrize('subscriber', [RELIABLE, qos_profile_sensor_data])
@pytest.mark.parametrize('stored', [(), (reliable_qos(),), (reliable_qos(1, latched=True),)])
def test_a_replayed_topic_serves_every_usual_subscriber(stored, subscriber):
    profile = replay_qos(BagTopic('/a', 'std_msgs/msg/String', 5, stored))
    assert qos_check_compatible(profile, subscriber)[0] != QoSCompatibility.ERROR


def test_nothing_is_discarded_before_it_is_acknowledged():
    assert replay_qos(BagTopic('/a', 'std_msgs/msg/String', 5, ())).history == HistoryPolicy.KEEP_ALL
    latched = BagTopic('/map', 'nav_msgs/msg/OccupancyGrid', 50, (reliable_qos(1, latched=True),))
    assert replay_qos(latched).depth >= 50
    assert qos_check_compatible(replay_qos(latched), LATCHED)[0] != QoSCompatibility.ERROR


@pytest.mark.parametrize(
    'publishers',
    [[RELIABLE], [qos_profile_sensor_data], [LATCHED], [LATCHED, qos_profile_sensor_data], [LATCHED, RELIABLE]],
)
def test_a_recorder_is_compatible_with_every_publisher(publishers):
    subscriber = recording_qos([Endpoint(each) for each in publishers])
    assert all(qos_check_compatible(each, subscriber)[0] != QoSCompatibility.ERROR for each in publishers)
    if len(publishers) == 1:  # it asks for all that is offered
        (only,) = publishers
        assert (subscriber.reliability, subscriber.durability) == (only.reliability, only.durability)


def test_the_bag_stores_what_was_offered():
    assert offered_qos([Endpoint(LATCHED)]) == reliable_qos(3, latched=True)
    both = offered_qos([Endpoint(LATCHED), Endpoint(qos_profile_sensor_data)])
    assert both.reliability is QosReliability.BEST_EFFORT
    assert both.durability is QosDurability.VOLATILE
