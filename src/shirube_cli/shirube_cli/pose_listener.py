"""Listens to a localizer while a bag is replayed: its poses, its delays and its reasons for having none."""

from typing import TypedDict

from diagnostic_msgs.msg import DiagnosticArray
from geometry_msgs.msg import PoseStamped
from rclpy.context import Context
from rclpy.node import Node
from rclpy.qos import QoSProfile, ReliabilityPolicy
from sensor_msgs.msg import CompressedImage
from std_msgs.msg import Header

from shirube_bags.stamps import NANOSECONDS


class MessageInfo(TypedDict):
    """What the middleware says of a message; only what is used here.

    Attributes:
        source_timestamp: when it was published, by the clock of this machine [ns].
    """

    source_timestamp: int


class PoseListener(Node):
    """Keeps what comes, by its stamp [ns].

    Attributes:
        localizer: name of the localizer's node.
        image_topic: topic of its images.
        images: when the image was published [ns].
        published: when the pose was published [ns].
        image_count: how many images came; more than ``images`` holds when a bag is played again.
        pose_count: how many poses came.
        delays: time between the publication of an image and of its pose [ns], one per pose.
        positions: position x, y, z of the pose [m].
        quaternions: orientation x, y, z, w of the pose.
        diagnostics: the latest values of the localizer's diagnostics.
        reports: how many diagnostics came.
    """

    def __init__(self, localizer: str, image_topic: str, context: Context) -> None:
        """Subscribe.

        Args:
            localizer: name of the localizer's node.
            image_topic: topic of its images.
            context: the ROS context to live in.
        """
        super().__init__('pose_listener', context=context)
        self.images: dict[int, int] = {}
        self.published: dict[int, int] = {}
        self.image_count = 0
        self.pose_count = 0
        self.delays: list[int] = []
        # An image and its pose come on two topics, either may be first.
        self._waiting: dict[int, int] = {}
        self._early: dict[int, int] = {}
        self._latest = 0
        self.positions: dict[int, tuple[float, float, float]] = {}
        self.quaternions: dict[int, tuple[float, float, float, float]] = {}
        self.diagnostics: dict[str, str] = {}
        self.reports = 0
        self.localizer = localizer
        self.image_topic = image_topic
        lossless = QoSProfile(depth=1000, reliability=ReliabilityPolicy.RELIABLE)
        self.create_subscription(CompressedImage, image_topic, self._take_image, lossless)
        self._poses = self.create_subscription(PoseStamped, f'/{localizer}/pose', self._take_pose, lossless)
        self.create_subscription(DiagnosticArray, '/diagnostics', self._take_diagnostics, lossless)

    def sees_localizer(self) -> bool:
        """Return whether the subscription has found the publisher of the poses."""
        return int(self._poses.get_publisher_count()) > 0

    def reasons(self) -> dict[str, int]:
        """Return how many images had no pose for which reason, in the node's words."""
        prefix = 'images without: '
        return {
            key.removeprefix(prefix): int(value)
            for key, value in self.diagnostics.items()
            if key.startswith(prefix)
        }

    def _take_image(self, message: CompressedImage, info: MessageInfo) -> None:
        stamp, sent = _stamp(message.header), info['source_timestamp']
        self.images[stamp] = sent
        self.image_count += 1
        published = self._early.pop(stamp, None)
        if stamp < self._latest:
            # The bag begins again: what waits belongs to the round before.
            self._waiting.clear()
            self._early.clear()
        self._latest = stamp
        if published is None:
            self._waiting[stamp] = sent
        else:
            self.delays.append(published - sent)

    def _take_pose(self, message: PoseStamped, info: MessageInfo) -> None:
        stamp, p, q = _stamp(message.header), message.pose.position, message.pose.orientation
        self.published[stamp] = info['source_timestamp']
        self.pose_count += 1
        sent = self._waiting.pop(stamp, None)
        if sent is None:
            self._early[stamp] = self.published[stamp]
        else:
            self.delays.append(self.published[stamp] - sent)
        self.positions[stamp] = (p.x, p.y, p.z)
        self.quaternions[stamp] = (q.x, q.y, q.z, q.w)

    def _take_diagnostics(self, message: DiagnosticArray) -> None:
        for status in message.status:
            if status.name.startswith(self.localizer):
                self.diagnostics = {pair.key: pair.value for pair in status.values}
                self.reports += 1


def _stamp(header: Header) -> int:
    return int(header.stamp.sec) * NANOSECONDS + int(header.stamp.nanosec)
