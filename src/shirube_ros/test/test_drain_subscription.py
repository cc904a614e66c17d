"""Queued messages reach the callback in order, each once."""

from __future__ import annotations

from node_testing import IsolatedGraph
from rclpy.node import Node
from std_msgs.msg import Int32

from shirube_ros.node import drain_subscription


def test_all_that_waits_is_taken_in_its_order(graph: IsolatedGraph) -> None:
    publisher_node = graph.add(lambda **options: Node('publisher', **options))
    listener = graph.add(lambda **options: Node('listener', **options))
    publisher = publisher_node.create_publisher(Int32, 'number', 100)
    received: list[int] = []
    counts: list[int] = []

    def take(message: Int32) -> None:
        received.append(message.data)
        if message.data == 0:
            for number in range(1, 50):
                publisher.publish(Int32(data=number))
            while len(received) < 50:
                drain_subscription(subscription)
            counts.append(len(received))

    subscription = listener.create_subscription(Int32, 'number', take, 100)
    assert graph.spin_until(lambda: publisher.get_subscription_count() == 1)
    publisher.publish(Int32(data=0))
    assert graph.spin_until(lambda: bool(counts), 10.0)
    assert received == list(range(50))
