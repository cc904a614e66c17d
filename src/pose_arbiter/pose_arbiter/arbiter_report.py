"""Diagnostics of the node: which sources are used or rejected, and why; logs important changes."""

import math
from collections.abc import Callable

from rclpy.node import Node

from pose_arbiter.core.arbiter import Arbiter
from pose_arbiter.core.kalman_filter import Estimate
from pose_arbiter.core.localization_status import LocalizationStatus
from pose_arbiter.core.measurement import MeasurementStatus
from pose_arbiter.core.outlier_rejection import FilterState
from pose_arbiter.core.settings import SourceSettings
from pose_arbiter.core.source_state import SourceState
from shirube_ros.diagnostics import Level, Status

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
        """Start without a state.

        Args:
            node: node that logs.
            arbiter: arbiter to report.
            sources: settings of the sources, by name.
            now: returns the current time [ns].
        """
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
        xx, _, _, yy, _, tt = estimate.covariance
        return f'{math.sqrt(max(xx, yy)):.3f} m, {math.degrees(math.sqrt(tt)):.2f} deg'


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
