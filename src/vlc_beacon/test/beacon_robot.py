"""The node under test with simulated topics, and a receiver that records its inputs."""

import math
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
from diagnostic_msgs.msg import DiagnosticArray, DiagnosticStatus
from geometry_msgs.msg import PoseStamped, Quaternion, QuaternionStamped
from nav_msgs.msg import Odometry
from node_testing import IsolatedGraph, NodeUser, header
from rclpy.node import Node
from receptions import POSE, with_fix
from sensor_msgs.msg import CameraInfo, Image, Imu

from shirube_core.geometry import SE2
from shirube_ros.camera.image import image_from_array
from shirube_ros.message_conversion import odometry_message
from vlc_beacon.core.receiver.beacon_receiver import ReceiverOutput
from vlc_beacon.node import VlcBeaconNode

PIXELS = np.random.default_rng(4).integers(0, 256, (100, 160), dtype=np.uint8)
INFO = CameraInfo(width=160, height=100, k=[100.0, 0.0, 80.0, 0.0, 100.0, 50.0, 0.0, 0.0, 1.0])
LEANING = Quaternion(x=math.sin(0.05), w=math.cos(0.05))
NOWHERE = Quaternion(x=math.nan)
IMAGES = (('image_raw', Image), ('camera_info', CameraInfo))
TOPICS = (*IMAGES, ('odom', Odometry), ('imu', Imu), ('attitude', QuaternionStamped))


class FakeReceiver:
    """Remembers its calls and answers what it is told to."""

    def __init__(self) -> None:
        self.calls: list[tuple[Any, ...]] = []
        self.answer: ReceiverOutput | Exception = with_fix()

    def add_odometry(self, *given: Any) -> None:
        self.calls.append(('odometry', *given))

    def add_tilt(self, *given: Any) -> None:
        self.calls.append(('tilt', *given))

    def receive(self, *given: Any) -> ReceiverOutput:
        self.calls.append(('receive', *given))
        if isinstance(self.answer, Exception):
            raise self.answer
        return self.answer


class Robot(NodeUser):
    """The node under test and a robot around it."""

    def __init__(self, graph: IsolatedGraph, beacons_file: Path, **parameters: Any) -> None:
        self._graph = graph
        self.receivers: list[FakeReceiver] = []
        self.node = graph.add(self._make_node, beacons_file=str(beacons_file), **parameters)
        self.robot = graph.add(lambda **options: Node('robot', **options))
        self.publishers = {topic: self.robot.create_publisher(kind, topic, 10) for topic, kind in TOPICS}
        self.poses = self.listen(PoseStamped, 'pose')
        self.reports: list[DiagnosticStatus] = []
        self.robot.create_subscription(DiagnosticArray, '/diagnostics', self._add_reports, 10)
        assert graph.spin_until(self._is_connected)

    def _add_reports(self, array: DiagnosticArray) -> None:
        self.reports += array.status

    def _make_node(self, **options: Any) -> VlcBeaconNode:
        def create_receiver(*_: object) -> FakeReceiver:
            self.receivers.append(FakeReceiver())
            return self.receivers[-1]

        return VlcBeaconNode(create_receiver, **options)  # type: ignore[arg-type]

    def _is_connected(self) -> bool:
        counts = [publisher.get_subscription_count() for publisher in self.publishers.values()]
        counts += [self.robot.count_publishers(topic) for topic in ('/vlc_beacon/pose', '/diagnostics')]
        return set(counts) == {1}

    @property
    def receiver(self) -> FakeReceiver:
        return self.receivers[-1]

    def send_image(self, stamp: float = 10.0) -> None:
        self.send('camera_info', INFO)
        self.send('image_raw', image_from_array(PIXELS, header(stamp, 'ceiling_optical_frame')))

    def wait_until(self, is_over: Callable[[], bool]) -> None:
        assert self._graph.spin_until(is_over)


def odometry(stamp: float, pose: SE2 = POSE, child_frame: str = 'base_link') -> Odometry:
    return odometry_message(pose, np.eye(3), header(stamp, 'odom'), child_frame)
