"""Input of the arbiter: the clock, and the poses of the sources, odometry and the initial pose."""

from collections.abc import Callable
from functools import partial
from typing import Any

from geometry_msgs.msg import PoseStamped, PoseWithCovarianceStamped
from nav_msgs.msg import Odometry
from rclpy.node import Node

from pose_arbiter.core.arbiter import OPERATOR, Arbiter
from pose_arbiter.core.settings import SourceSettings
from pose_arbiter.core.source_state import RejectReason
from pose_arbiter.node_settings import NodeSettings
from shirube_ros.errors import FrameError, MessageError
from shirube_ros.frames import Frames
from shirube_ros.input_watch import Need
from shirube_ros.managed_node import ManagedNode
from shirube_ros.message_conversion import planar_pose
from shirube_ros.quality_of_service import odometry_profile, pose_profile

ODOMETRY, INITIAL_POSE = 'odom', 'initialpose'
_REMEDIES = {
    RejectReason.NOT_FINITE: 'check its publisher',
    RejectReason.TOO_FAR: 'check its publisher',
    RejectReason.BAD_COVARIANCE: 'let its publisher fill in the covariance, or set with_covariance to false',
    RejectReason.NO_STAMP: 'let its publisher set header.stamp',
    RejectReason.FUTURE: 'synchronize the clocks, and set use_sim_time of all nodes to the same value',
    RejectReason.TOO_OLD: 'set use_sim_time of all nodes to the same value, or raise history_seconds',
    RejectReason.DUPLICATE: 'give each message its own stamp, and each topic one publisher',
}
_JUMP_BACK_MIN = 100_000_000  # tolerated step back when a clock is synchronized [ns]
_JUMP_AHEAD_MIN = 10_000_000_000  # a larger step ahead of simulated time is a jump [ns]


class ClockMonitor:
    """Reads the node's clock and reports jumps."""

    def __init__(self, node: Node, on_jump: Callable[[], None]) -> None:
        """Start; ``on_jump`` is called when time jumped back, or when simulated time jumped ahead."""
        self._clock, self._on_jump = node.get_clock(), on_jump
        self._is_simulated = bool(node.get_parameter('use_sim_time').value)
        self._latest = 0

    def now(self) -> int:
        """Return the current time [ns], 0 before simulated time has started."""
        now = int(self._clock.now().nanoseconds)
        before, self._latest = self._latest, now
        jumped_ahead = self._is_simulated and 0 < before < now - _JUMP_AHEAD_MIN
        if now < before - _JUMP_BACK_MIN or jumped_ahead:
            self._on_jump()
        return now


class ArbiterInput:
    """Subscribes and passes messages to the arbiter."""

    def __init__(
        self,
        node: ManagedNode,
        arbiter: Arbiter,
        sources: dict[str, SourceSettings],
        frames: NodeSettings,
        now: Callable[[], int],
    ) -> None:
        """Subscribe.

        Args:
            node: node that subscribes; it counts received and rejected messages by source name.
            arbiter: receives the poses and odometry.
            sources: settings of the sources, by name.
            frames: required frames of the initial pose and of odometry.
            now: returns the current time [ns], 0 before the first /clock; checks for clock jumps.
        """
        self._arbiter, self._now = arbiter, now
        self._map_frame, self._odom_frame = frames.map_frame, frames.odom_frame
        self._own_frames, self._frames = ((frames.odom_frame, frames.base_frame), Frames(node, frames.base_frame))
        self.twist: Any = None  # twist of the latest odometry message
        for index, (name, source) in enumerate(sources.items()):
            kind = PoseWithCovarianceStamped if source.with_covariance else PoseStamped
            callback = partial(self._on_pose, index, name, source)
            node.subscribe(kind, source.topic, callback, pose_profile(), Need.EXPECTED, name=name)
        node.subscribe(Odometry, ODOMETRY, self._on_odometry, odometry_profile(), Need.EXPECTED, name=ODOMETRY)
        set_pose = self._on_initial_pose
        node.subscribe(PoseWithCovarianceStamped, INITIAL_POSE, set_pose, pose_profile(), Need.REQUEST)

    def _on_pose(self, index: int, name: str, source: SourceSettings, message: Any) -> None:
        frame = message.header.frame_id
        refusal = f'poses of {name} have frame_id {frame!r}, expected {source.frame!r}; set {name}.frame or map_frame'
        # A transform through map to odom would be a pose of this node itself.
        if frame != source.frame and frame in ('', *self._own_frames):
            raise FrameError(refusal)
        noise = None
        if source.with_covariance:
            pose, noise = self._frames.pose_with_covariance_to(source.frame, message, name, refusal)
        else:
            pose = self._frames.pose_to(source.frame, message.header, planar_pose(message.pose, name), refusal)
        stamp = _nanoseconds(message)
        _raise_if_rejected(name, self._arbiter.add_pose(index, stamp, pose, noise, self._time()))

    def _on_odometry(self, message: Odometry) -> None:
        if message.header.frame_id not in ('', self._odom_frame):
            raise MessageError(
                f'odometry has frame_id {message.header.frame_id!r}, expected {self._odom_frame!r}; set odom_frame'
            )
        stamp = _nanoseconds(message)
        pose = planar_pose(message.pose.pose, ODOMETRY)
        _raise_if_rejected(ODOMETRY, self._arbiter.add_odometry(stamp, pose, self._time()))
        self.twist = message.twist

    def _on_initial_pose(self, message: PoseWithCovarianceStamped) -> None:
        refusal = (
            f'{INITIAL_POSE} has frame_id {message.header.frame_id!r}, expected {self._map_frame!r}; '
            'publish it in map_frame'
        )
        pose, covariance = self._frames.pose_with_covariance_to(
            self._map_frame, message, INITIAL_POSE, refusal, is_latest_valid=True
        )
        now = self._time()
        stamp = _nanoseconds(message) or now
        _raise_if_rejected(INITIAL_POSE, self._arbiter.add_pose(OPERATOR, stamp, pose, covariance, now))

    def _time(self) -> int:
        """Return the current time [ns]; without it no stamp can be checked.

        Raises:
            MessageError: simulated time has not started.
        """
        now = self._now()
        if now == 0:
            raise MessageError('simulated time has not started; publish /clock, or set use_sim_time to false')
        return now


def _nanoseconds(message: Any) -> int:
    """Return the stamp of a message [ns], without loss."""
    return int(message.header.stamp.sec * 1_000_000_000 + message.header.stamp.nanosec)


def _raise_if_rejected(name: str, reason: RejectReason | None) -> None:
    if reason is not None:
        raise MessageError(f'{name}: {reason.value}; {_REMEDIES[reason]}')
