"""Output of the arbiter at a fixed rate: the fused pose, map to odom on /tf, and the diagnostics."""

import math
from collections.abc import Callable
from typing import Any

import numpy as np
from builtin_interfaces.msg import Time
from geometry_msgs.msg import PoseStamped, PoseWithCovarianceStamped
from nav_msgs.msg import Odometry
from rclpy.node import Node
from std_msgs.msg import Header

from pose_arbiter.core.arbiter import Arbiter, LocalizationStatus
from pose_arbiter.core.kalman_filter import Estimate
from pose_arbiter.core.outlier_rejection import FilterState
from pose_arbiter.core.settings import SourceSettings
from pose_arbiter.core.source_state import MeasurementStatus, SourceState
from pose_arbiter.node_settings import NodeSettings
from shirube_core.geometry import SE2
from shirube_ros.diagnostics import Level, Status
from shirube_ros.frames import TransformPublisher
from shirube_ros.message_conversion import odometry_message, pose_message, pose_stamped, pose_with_covariance_stamped
from shirube_ros.quality_of_service import pose_profile

_LEVELS = {
    LocalizationStatus.WAITING: Level.WARN,
    LocalizationStatus.TRACKING: Level.OK,
    LocalizationStatus.ODOMETRY_ONLY: Level.WARN,
    LocalizationStatus.LOST: Level.ERROR,
}
_ACCEPTED = (MeasurementStatus.USED, MeasurementStatus.RESET)
_ODOMETRY_TIMEOUT = 0.5  # [s]


class ArbiterReport:
    """Builds the diagnostics status once a second, and logs resets and a lost pose at once."""

    def __init__(
        self, node: Node, arbiter: Arbiter, sources: dict[str, SourceSettings], now: Callable[[], int]
    ) -> None:
        """Start without a state; ``now`` returns the current time [ns]."""
        self._node, self._arbiter, self._sources, self._now = node, arbiter, sources, now
        self._status, self._resets = LocalizationStatus.WAITING, 0
        self._state: FilterState | None = None
        self._estimate: Estimate | None = None

    def apply_settings(self, sources: dict[str, SourceSettings]) -> None:
        """Use changed settings of the sources."""
        self._sources = sources

    def observe(self, state: FilterState, estimate: Estimate | None, status: LocalizationStatus) -> None:
        """Store the current state; log a reset, and when the pose is lost or found again."""
        if state.resets > self._resets and estimate is not None:
            place = f'x {estimate.x:.2f} m, y {estimate.y:.2f} m, yaw {math.degrees(estimate.yaw):.0f} deg'
            self._node.get_logger().info(f'pose reset to {place}')
        if status is not self._status and LocalizationStatus.LOST in (status, self._status):
            if status is LocalizationStatus.LOST:
                self._node.get_logger().error(f'LOST: {self._sigmas(estimate)}')
            else:
                self._node.get_logger().info(status.value)
        self._status, self._resets = status, state.resets
        self._state, self._estimate = state, estimate

    def status(self) -> Status:
        """Return the status for the diagnostics."""
        now = self._now()
        values = {'state': self._status.value, 'resets': str(self._resets)}
        if self._estimate is not None:
            values['sigma'] = self._sigmas(self._estimate)
        parts, all_ok = [], True
        for number, (name, source) in enumerate(self._sources.items()):
            source_state = SourceState() if self._state is None else self._state.source_states[number]
            description, is_ok = _source_status(source_state, source, now)
            values[name] = description
            all_ok = all_ok and is_ok
            parts.append(f'{name} {description}')
        parts.append(self._odometry_status(now))
        for (number, status), count in sorted(self._arbiter.counts().items(), key=lambda item: str(item[0])):
            name = 'initialpose' if number < 0 else list(self._sources)[number]
            values[f'{name}: {status.value}'] = str(count)
        level = _LEVELS[self._status]
        if level is Level.OK and not all_ok:
            level = Level.WARN
        return Status(level, f'{self._status.value}: {", ".join(parts)}', values)

    def _odometry_status(self, now: int) -> str:
        latest = self._arbiter.latest_odometry
        if latest is None:
            return 'no odometry'
        age = (now - latest) * 1e-9
        return f'no odometry for {age:.1f} s' if age > _ODOMETRY_TIMEOUT else 'odometry used'

    def _sigmas(self, estimate: Estimate | None) -> str:
        if estimate is None:
            return 'unknown'
        x, y, yaw = np.sqrt(estimate.covariance.diagonal()).tolist()
        return f'{max(x, y):.3f} m, {math.degrees(yaw):.2f} deg'


def _source_status(source_state: SourceState, source: SourceSettings, now: int) -> tuple[str, bool]:
    """Return the status text of a source, and whether it is no reason for a warning."""
    if source_state.latest is None or source_state.status is None:
        return 'no message', True
    age = (now - source_state.latest.odometry.stamp) * 1e-9
    if age > source.timeout:
        return f'no message for {age:.1f} s', True
    if source_state.status in _ACCEPTED:
        return 'used', True
    if source_state.status is MeasurementStatus.WAITING:
        return source_state.status.value, True
    return f'rejected ({source_state.status.value})', False


_BACKLOG_MAX = 500_000_000  # older ticks are dropped [ns]


class TickSchedule:
    """Ticks at multiples of the period, none skipped under load; integers, so that they do not drift."""

    def __init__(self, rate: float) -> None:
        """Start at the first call of `due`, with a tick rate [1/s]."""
        self._period = round(1e9 / rate)
        self._last_done: int | None = None

    def reset(self) -> None:
        """Drop the due ticks after a clock jump."""
        self._last_done = None

    def due(self, now: int) -> range:
        """Return the stamps of the ticks since the last call, up to now [ns]."""
        last = now // self._period
        if self._last_done is None:
            self._last_done = last - 1
        first = max(self._last_done + 1, (now - _BACKLOG_MAX) // self._period + 1)
        self._last_done = max(self._last_done, last)
        return range(first * self._period, last * self._period + 1, self._period)


# Least standard deviations of an area for another localizer [m], [rad].
_AREA_SIGMA, _AREA_SIGMA_YAW = 0.05, 0.05


class ArbiterOutput:
    """Publishers of the fused pose and of the transform."""

    def __init__(self, node: Node, settings: NodeSettings) -> None:
        self._settings = settings
        self._pose = node.create_publisher(PoseStamped, '~/pose', pose_profile())
        self._odometry = node.create_publisher(Odometry, '~/odometry', pose_profile())
        self._transforms = TransformPublisher(node) if settings.publish_tf else None
        if settings.initialpose_for:
            self._area = node.create_publisher(PoseWithCovarianceStamped, '~/initialpose', pose_profile())

    def publish_pose(self, stamp: int, estimate: Estimate, twist: Any) -> None:
        """Publish the pose at a stamp [ns], with the twist of the latest odometry message or None."""
        header = Header(stamp=_time(stamp), frame_id=self._settings.map_frame)
        self._pose.publish(pose_stamped(estimate.pose, header))
        message = odometry_message(estimate.pose, estimate.covariance, header, self._settings.base_frame)
        if twist is not None:
            message.twist = twist
        self._odometry.publish(message)

    def publish_area(self, stamp: int, estimate: Estimate) -> None:
        """Publish the pose at a stamp [ns] as the area where a silent localizer searches first."""
        covariance = estimate.covariance.copy()
        least = np.array([_AREA_SIGMA, _AREA_SIGMA, _AREA_SIGMA_YAW]) ** 2
        np.fill_diagonal(covariance, np.maximum(covariance.diagonal(), least))
        header = Header(stamp=_time(stamp), frame_id=self._settings.map_frame)
        self._area.publish(pose_with_covariance_stamped(estimate.pose, covariance, header))

    def publish_transform(self, stamp: int, T_map_odom: SE2) -> None:
        """Publish the pose of the odometry frame in the map, stamped ``transform_tolerance`` ahead of a stamp [ns]."""
        if self._transforms is not None:
            ahead = _time(stamp + round(1e9 * self._settings.transform_tolerance))
            parent, child = self._settings.map_frame, self._settings.odom_frame
            self._transforms.publish(ahead, parent, child, pose_message(T_map_odom))


def _time(stamp: int) -> Time:
    """Return a stamp [ns] as a message, without loss."""
    sec, nanosec = divmod(stamp, 1_000_000_000)
    return Time(sec=sec, nanosec=nanosec)
