"""Records a mission to a bag: all small messages, and the images of an extract."""

from collections.abc import Callable, Mapping
from functools import partial
from pathlib import Path

import numpy as np
from geometry_msgs.msg import PoseStamped, PoseWithCovarianceStamped, TwistStamped
from nav_msgs.msg import OccupancyGrid, Odometry
from nav_msgs.msg import Path as PathMessage
from numpy.typing import NDArray
from rclpy.node import Node
from rclpy.qos import HistoryPolicy, QoSProfile, ReliabilityPolicy
from rclpy.serialization import deserialize_message, serialize_message
from rosbags.interfaces import Qos
from sensor_msgs.msg import CameraInfo, Image, Imu, JointState
from std_msgs.msg import String

from scene_simulator.messages import compressed_image
from shirube_bags.bag_reader import jazzy_types
from shirube_bags.bag_writer import BagWriter
from shirube_bags.ros_session import offered_qos
from shirube_bags.trajectory_files import header_stamp
from shirube_bringup.topics import stamp_ns
from shirube_ros.camera.image import array_from_image, depth_from_image

TOPICS_AT_STAMP: Mapping[str, type] = {
    '/ground_truth': PoseStamped,
    '/imu': Imu,
    '/odom': Odometry,
    '/joint_states': JointState,
    '/pose_arbiter/pose': PoseStamped,
    '/pose_arbiter/odometry': Odometry,
}
"""Topics recorded at the time of their header stamp."""

TOPICS_AT_STEP: Mapping[str, type] = {
    **{
        f'/{name}/{kind}': message
        for name in ('floor_localizer', 'vlc_beacon', 'stereo_landmark')
        for kind, message in (('pose', PoseStamped), ('pose_with_covariance', PoseWithCovarianceStamped))
    },
    '/vlc_beacon/command': String,
    '/goal_pose': PoseStamped,
    '/reward_planner/map': OccupancyGrid,
    '/reward_planner/local_map': OccupancyGrid,
    '/reward_planner/plan': PathMessage,
    '/reward_planner/next_waypoint': PoseStamped,
    '/cmd_vel': TwistStamped,
}
"""Topics recorded at the current time step, with latency or without a stamp."""

CAMERA_INFOS: Mapping[str, type] = dict.fromkeys(
    (f'/{camera}/camera_info' for camera in ('floor', 'ceiling', 'left', 'right', 'depth')), CameraInfo
)
"""CameraInfo topics, recorded with the images."""

PICTURES: Mapping[str, int] = {
    '/floor/image_raw': 90,
    '/ceiling/image_raw': 60,
    '/left/image_rect': 85,
    '/right/image_rect': 85,
}
"""Topics of grey images, and the quality of their JPEG compression."""

DEPTH = '/depth/image'
EXTRACT_MS = (14_000, 34_000)
"""Mission times between which images are recorded [ms]: from the carpet over the first goal onto dots."""

_COMPRESSED = 'sensor_msgs/msg/CompressedImage'


class MissionBag:
    """Buffers the messages until the mission is over, then writes them to ``path``, sorted by time."""

    def __init__(self, node: Node, path: Path, now: Callable[[], int]) -> None:
        """Subscribe; ``now`` returns the mission time [ms]."""
        self.path = path
        self._node, self._now = node, now
        self._messages: list[tuple[int, str, str, bytes]] = []
        self._qos: dict[str, Qos] = {}
        for topic, kind in TOPICS_AT_STAMP.items():
            self._subscribe(topic, kind, partial(self._record_at_stamp, topic, type_name(kind)))
        for topic, kind in TOPICS_AT_STEP.items():
            self._subscribe(topic, kind, partial(self._record_now, topic, type_name(kind)))
        for topic, kind in CAMERA_INFOS.items():
            self._subscribe(topic, kind, partial(self._record_in_extract, topic, type_name(kind)))
        for topic, quality in PICTURES.items():
            self._subscribe(topic, Image, partial(self._record_image, topic, quality))
        self._subscribe(DEPTH, Image, self._record_depth)

    def write(self) -> int:
        """Write the bag and return its number of messages, or raise BagError."""
        # Messages with equal time are sorted by topic; the sort is stable within a topic.
        self._messages.sort(key=lambda message: message[:2])
        with BagWriter(self.path) as bag:
            for stamp, topic, kind, raw in self._messages:
                bag.declare(topic, kind, self._qos[topic])
                bag.write_raw(topic, kind, raw, stamp)
            return bag.message_count

    def _subscribe(self, topic: str, kind: type, callback: Callable[[bytes], None]) -> None:
        qos = QoSProfile(history=HistoryPolicy.KEEP_ALL, reliability=ReliabilityPolicy.RELIABLE)
        self._node.create_subscription(kind, topic, callback, qos, raw=True)

    def _record_at_stamp(self, topic: str, kind: str, raw: bytes) -> None:
        self._record(header_stamp(raw), topic, topic, kind, raw)

    def _record_now(self, topic: str, kind: str, raw: bytes) -> None:
        self._record(stamp_ns(self._now()), topic, topic, kind, raw)

    def _record_in_extract(self, topic: str, kind: str, raw: bytes) -> None:
        if is_in_extract(header_stamp(raw)):
            self._record_now(topic, kind, raw)

    def _record_image(self, topic: str, quality: int, raw: bytes) -> None:
        stamp = header_stamp(raw)
        if not is_in_extract(stamp):
            return
        image = deserialize_message(raw, Image)
        pixels: NDArray[np.uint8] = array_from_image(image, topic)
        compressed = compressed_image(pixels, image.header.frame_id, stamp, quality, progressive=True)
        serialized = bytes(jazzy_types().serialize_cdr(compressed, _COMPRESSED))
        self._record(stamp_ns(self._now()), topic, f'{topic}/compressed', _COMPRESSED, serialized)

    def _record_depth(self, raw: bytes) -> None:
        if not is_in_extract(header_stamp(raw)):
            return
        image = deserialize_message(raw, Image)
        depth = depth_from_image(image, DEPTH)
        # Integer millimetres take a third of the space.
        depth_mm = np.rint(1e3 * np.where(np.isfinite(depth), depth, 0.0)).astype(np.uint16)
        image.encoding, image.step = '16UC1', 2 * image.width
        image.data = depth_mm.tobytes()
        self._record_now(DEPTH, type_name(Image), serialize_message(image))

    def _record(self, stamp: int, source: str, topic: str, kind: str, raw: bytes) -> None:
        if topic not in self._qos:
            self._qos[topic] = offered_qos(self._node.get_publishers_info_by_topic(source))
        self._messages.append((stamp, topic, kind, raw))


def type_name(kind: type) -> str:
    """Return the name of a message type, such as sensor_msgs/msg/Image."""
    return f'{kind.__module__.split(".")[0]}/msg/{kind.__name__}'


def is_in_extract(stamp: int) -> bool:
    """Return whether images of this stamp [ns] are recorded."""
    begin, end = EXTRACT_MS
    return stamp_ns(begin) <= stamp < stamp_ns(end)
