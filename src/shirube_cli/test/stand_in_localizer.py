"""A localizer that knows the truth: publishes the bag's ground truth, a known distance beside it."""

import sys

import rclpy
from diagnostic_msgs.msg import DiagnosticArray, DiagnosticStatus, KeyValue
from geometry_msgs.msg import PoseStamped
from rclpy.node import Node
from sensor_msgs.msg import CompressedImage

from shirube_ros.node import run_node

NAME = 'floor_localizer'
OFFSET = 0.002


def create_localizer() -> Node:
    node = rclpy.create_node(NAME)
    publisher = node.create_publisher(PoseStamped, '~/pose', 10)
    diagnostics = node.create_publisher(DiagnosticArray, '/diagnostics', 10)
    node.create_subscription(CompressedImage, '/image_raw/compressed', lambda _: None, 10)

    def answer(truth: PoseStamped) -> None:
        truth.pose.position.x += OFFSET
        publisher.publish(truth)

    def report() -> None:
        values = [KeyValue(key='images without: ambiguous', value='3')]
        diagnostics.publish(DiagnosticArray(status=[DiagnosticStatus(name='floor_localizer: status', values=values)]))

    node.create_subscription(PoseStamped, '/ground_truth', answer, 10)
    node.create_timer(0.5, report)
    return node


if __name__ == '__main__':
    sys.exit(int(sys.argv.pop(1)) or run_node(NAME, create_localizer))
