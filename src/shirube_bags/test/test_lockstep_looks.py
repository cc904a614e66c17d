"""Lockstep with nodes that poll the clock, then messages, then requests, with time in between."""

import time
from threading import Event, Thread

import numpy as np
import pytest
import rclpy
from rclpy.executors import SingleThreadedExecutor
from rclpy.node import Node
from rclpy.service import Service
from rclpy.subscription import Subscription
from sensor_msgs.msg import Image

from shirube_bags.bag_player import BagPlayer
from shirube_bags.bag_reader import BagReader
from shirube_bags.lockstep import Lockstep

pytestmark = pytest.mark.newest_set_only

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
