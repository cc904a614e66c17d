"""The node under test with a fake robot that publishes its inputs and records its outputs."""

from functools import partial
from pathlib import Path
from typing import Any
from unittest.mock import Mock

from diagnostic_msgs.msg import DiagnosticArray, DiagnosticStatus
from geometry_msgs.msg import PoseStamped, Quaternion, TransformStamped
from node_testing import IsolatedGraph, NodeUser, header
from rclpy.node import Node
from rclpy.publisher import Publisher
from scipy.spatial.transform import Rotation
from sensor_msgs.msg import CameraInfo, Image, Imu
from std_msgs.msg import Header
from taught_wall import CALIBRATIONS, MOUNT, SIDES, TAUGHT, seen

from shirube_ros.camera.image import image_from_array
from stereo_landmark.core.pair.camera_pair import CameraCalibration
from stereo_landmark.core.pair.pair_stream import PairStream
from stereo_landmark.node import StereoLandmarkNode


class Robot(NodeUser):
    """The node under test and its publishers and subscribers.

    Attributes:
        streams: streams that a fake node asked for; their calls are recorded, and they have no fix unless one is set.
    """

    def __init__(self, graph: IsolatedGraph, places: Path, *, is_real: bool = False, **parameters: Any) -> None:
        self._graph = graph
        self.streams: list[Mock] = []
        given = {'places_dir': str(places), 'camera_xyz': list(MOUNT.xyz), **parameters}
        create_stream = () if is_real else (self._create_stream,)
        self.node = graph.add(partial(StereoLandmarkNode, *create_stream), **given)
        self.robot = graph.add(lambda **options: Node('robot', **options))
        self.publishers = input_publishers(self.robot)
        self.displacements = self.listen(TransformStamped, 'displacement')
        self.poses = self.listen(PoseStamped, 'pose')
        self.reports: list[DiagnosticStatus] = []
        self.robot.create_subscription(
            DiagnosticArray, '/diagnostics', lambda array: self.reports.extend(array.status), 10
        )
        assert graph.spin_until(self._is_connected)

    def _create_stream(self, *_: object) -> Mock:
        self.streams.append(Mock(PairStream, **{'add_image.return_value': None}))
        return self.stream

    def _is_connected(self) -> bool:
        counts = [publisher.get_subscription_count() for publisher in self.publishers.values()]
        return set(counts) == {1} and self.robot.count_publishers('/diagnostics') == 1

    @property
    def stream(self) -> Mock:
        return self.streams[-1]

    def send_pair(self, stamp: float = 10.0, pair: Any = None, later: float = 0.0) -> None:
        images = seen(TAUGHT) if pair is None else pair
        for side, image, calibration in zip(SIDES, images, CALIBRATIONS, strict=True):
            self.send(f'{side}/camera_info', info(calibration))
            when = stamp + (later if side == 'right' else 0.0)
            self.send(f'{side}/image_rect', image_from_array(image, header(when, f'{side}_optical_frame')))


def input_publishers(node: Node) -> dict[str, Publisher]:
    """Return publishers of all inputs by topic."""
    kinds = {f'{side}/image_rect': Image for side in SIDES}
    kinds |= {f'{side}/camera_info': CameraInfo for side in SIDES} | {'imu': Imu}
    return {topic: node.create_publisher(kind, topic, 10) for topic, kind in kinds.items()}


def info(calibration: CameraCalibration, at: Header | None = None) -> CameraInfo:
    raw = calibration.raw
    return CameraInfo(
        header=at or Header(), width=raw.width, height=raw.height, distortion_model='plumb_bob', d=list(raw.distortion),
        k=raw.matrix.ravel(), r=calibration.rotation, p=calibration.projection,
    )  # fmt: skip


def imu(at: Header, tilt: tuple[float, ...]) -> Imu:
    x, y, z, w = Rotation.from_euler('xyz', (*tilt, 0.0)).as_quat().tolist()
    return Imu(header=at, orientation=Quaternion(x=x, y=y, z=z, w=w))
