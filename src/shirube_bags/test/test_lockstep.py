"""Lockstep replay and its barrier."""

import time
from threading import Event, Thread

import numpy as np
import pytest
import rclpy
from rclpy.executors import SingleThreadedExecutor
from rclpy.node import Node
from rclpy.qos import QoSProfile, qos_profile_sensor_data
from rclpy.service import Service
from rclpy.subscription import Subscription
from sensor_msgs.msg import Image
from std_msgs.msg import String

from shirube_bags.bag_reader import BagReader
from shirube_bags.bag_writer import BagWriter
from shirube_bags.errors import BagError, ReplayError
from shirube_bags.lockstep import Lockstep, replay_in_lockstep
from shirube_bags.ros_session import BagPlayer

SHORT_RELIABLE_QUEUE = QoSProfile(depth=1)
SHORT_BEST_EFFORT_QUEUE = QoSProfile(depth=1, reliability=qos_profile_sensor_data.reliability)


@pytest.mark.parametrize(
    ('qos', 'work'), [(qos_profile_sensor_data, 0.0), (SHORT_RELIABLE_QUEUE, 0.0), (SHORT_BEST_EFFORT_QUEUE, 0.01)]
)
def test_every_image_arrives_once_in_order_and_equal(stamp_of, ros, listen, bag_path, qos, work):
    listener = listen('listener', qos, work=work)
    player = ros.node('player')
    with BagReader(bag_path) as bag:
        count = replay_in_lockstep(bag, player, ros.executor)
        wanted = [bag.decode(each) for each in bag.messages(['/image_raw'])]
    assert count == 81
    assert listener.stamps() == listener.clock == [stamp_of(each) for each in wanted]
    for found, image in zip(listener.images, wanted):
        assert bytes(found.data) == image.data.tobytes()
        assert (found.encoding, found.width, found.step) == (image.encoding, image.width, image.step)


def test_messages_of_many_datagrams_are_worked_off_too(ros, listen, tmp_path, messages):
    with BagWriter(tmp_path / 'bag') as bag:
        for stamp in range(1, 11):
            bag.write('/image_raw', 'sensor_msgs/msg/Image', messages.image(stamp, side=700), stamp)
    listener = listen('listener', qos_profile_sensor_data)
    player = ros.node('player')
    with BagReader(tmp_path / 'bag') as bag:
        replay_in_lockstep(bag, player, ros.executor)
    assert listener.clock == list(range(1, 11))


def test_without_subscribers_the_replay_goes_on(ros, bag_path):
    player = ros.node('player')
    with BagReader(bag_path) as bag:
        assert replay_in_lockstep(bag, player, ros.executor) == 81


def test_a_node_without_parameter_services_is_named(ros, bag_path, monkeypatch):
    monkeypatch.setattr('shirube_bags.lockstep.DISCOVERY_TIMEOUT', 0.2)
    silent = ros.node('mute', start_parameter_services=False)
    silent.create_subscription(Image, 'image_raw', lambda _: None, 10)
    node = ros.node('player')
    with BagReader(bag_path) as bag:
        player = BagPlayer(node, bag.topics.values())
        assert ros.spin_until(lambda: player.subscriber_count('/image_raw'))
        lockstep = Lockstep(player, node, ros.executor)
        lockstep.wait(player.topics)
    assert lockstep.nodes_without_services == ('/mute',)


def test_a_node_that_hangs_is_named(ros, bag_path):
    # Its executor is not spun, so it answers nothing.
    node = ros.node('hanging')
    node.create_subscription(Image, 'image_raw', lambda _: None, 10)
    ros.executor.remove_node(node)
    player = ros.node('player')
    with BagReader(bag_path) as bag, pytest.raises(ReplayError, match='hanging has not responded for'):
        replay_in_lockstep(bag, player, ros.executor, timeout=0.2)


def test_an_unknown_topic_is_refused(ros, bag_path):
    with BagReader(bag_path) as bag, pytest.raises(BagError, match='has no topic /imu'):
        replay_in_lockstep(bag, ros.node('player'), ros.executor, ['/imu'])


def test_answers_of_the_node_come_before_the_next_message(stamp_of, ros, bag_path):
    """A node that answers each image: its answers alternate with the images."""
    order = []
    node = ros.node('echo')
    answers = node.create_publisher(String, 'answer', 10)

    def answer(image):
        order.append('image')
        answers.publish(String(data=str(stamp_of(image))))
        order.append('answer')

    node.create_subscription(Image, 'image_raw', answer, 10)
    with BagReader(bag_path) as bag:
        replay_in_lockstep(bag, ros.node('player'), ros.executor, ['/image_raw'])
    assert order == ['image', 'answer'] * 41


BETWEEN_LOOKS = 0.005


class DividedExecutor(SingleThreadedExecutor):
    """Polls one kind of entity after the other, as every executor does, but slowly."""

    wanted = 'clock'

    def can_execute(self, entity: object) -> bool:
        kind = 'rest'
        if isinstance(entity, Subscription):
            kind = 'clock' if entity.topic_name == '/clock' else 'message'
        elif isinstance(entity, Service):
            kind = 'question'
        return kind == self.wanted and super().can_execute(entity)

    def look(self) -> None:
        for self.wanted in ('clock', 'message', 'question', 'rest'):
            self._cb_iter = None  # a separate poll
            self.spin_once(timeout_sec=0.0)
            time.sleep(BETWEEN_LOOKS)


@pytest.fixture(params=[True, False], ids=['time of the bag', 'time of the day'])
def looker(domain: int, request):
    context = rclpy.Context()
    rclpy.init(context=context, domain_id=domain)
    time_of_bag = rclpy.Parameter('use_sim_time', value=request.param)
    node = Node('looker', context=context, parameter_overrides=[time_of_bag])
    executor = DividedExecutor(context=context)
    executor.add_node(node)
    stop = Event()

    def work() -> None:
        while not stop.is_set():
            executor.look()

    thread = Thread(target=work)
    thread.start()
    yield node
    stop.set()
    thread.join()
    executor.shutdown()
    node.destroy_node()
    context.try_shutdown()


@pytest.mark.newest_set_only
def test_each_message_is_worked_off_at_its_own_time(looker: Node, ros, bag_path) -> None:
    seen = []

    def note(image: Image) -> None:
        stamp = image.header.stamp
        seen.append((looker.get_clock().now().nanoseconds, stamp.sec * 10**9 + stamp.nanosec))

    looker.create_subscription(Image, 'image_raw', note, 1)
    follows_clock = looker.get_parameter('use_sim_time').value
    followed = ('/image_raw', '/clock') if follows_clock else ('/image_raw',)
    node = ros.node('player')
    pauses = np.random.default_rng(0)
    with BagReader(bag_path) as bag:
        player = BagPlayer(node, [bag.topics['/image_raw']])
        lockstep = Lockstep(player, node, ros.executor)
        while not all(player.subscriber_count(topic) for topic in followed):
            time.sleep(BETWEEN_LOOKS)
        lockstep.wait(player.topics)
        for count, message in enumerate(bag.messages(player.topics), 1):
            time.sleep(pauses.uniform(0.0, 4.0 * BETWEEN_LOOKS))
            lockstep.publish(message)
            assert len(seen) == count
    assert not follows_clock or all(now == stamp for now, stamp in seen)
