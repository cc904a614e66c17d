"""Fuses poses and odometry, received in any order, into one pose."""

import math
from bisect import bisect_left
from collections import Counter
from collections.abc import Sequence
from enum import Enum

from pose_arbiter.core.kalman_filter import Covariance, Estimate, diagonal, is_positive_definite, predict
from pose_arbiter.core.outlier_rejection import FilterState, OutlierRejection
from pose_arbiter.core.settings import ArbiterSettings, SourceSettings
from pose_arbiter.core.source_state import MeasurementStatus, PoseMeasurement, RejectReason
from shirube_core.geometry import SE2
from shirube_core.motion import NoPoseReason, OdometryBuffer


class LocalizationStatus(Enum):
    """Status of localization; the value is the text of the diagnostics."""

    WAITING = 'no pose yet'
    TRACKING = 'pose known'
    ODOMETRY_ONLY = 'no source supports the pose, odometry only'
    LOST = 'pose lost'

    @property
    def has_pose(self) -> bool:
        """Whether there is a pose to publish."""
        return self in (LocalizationStatus.TRACKING, LocalizationStatus.ODOMETRY_ONLY)


def localization_status(
    state: FilterState, estimate: Estimate | None, sources: tuple[SourceSettings, ...], settings: ArbiterSettings
) -> LocalizationStatus:
    """Return the localization status."""
    if estimate is None:
        return LocalizationStatus.WAITING
    (xx, xy, _), (_, yy, _), (_, _, tt) = estimate.covariance.tolist()
    max_variance = 0.5 * (xx + yy) + math.hypot(0.5 * (xx - yy), xy)  # the larger eigenvalue
    if max_variance > settings.lost_sigma_xy**2 or tt > settings.lost_sigma_yaw**2:
        return LocalizationStatus.LOST
    stamp = estimate.odometry.stamp
    if any(
        source_state.is_supporting(stamp, round(source.timeout * 1e9))
        for source_state, source in zip(state.source_states, sources, strict=True)
    ):
        return LocalizationStatus.TRACKING
    return LocalizationStatus.ODOMETRY_ONLY


OPERATOR = -1
"""Source index of poses set by an operator (`initialpose`)."""
_CLOCK_OFFSET_MAX = 100_000_000  # tolerated clock difference between hosts [ns]
_FARTHEST = 1e6  # [m]
_VAR_MIN, _VAR_XY_MAX, _VAR_YAW_MAX = 1e-14, 1e4, math.tau**2


class Arbiter:
    """Fuses all sources and odometry into one pose.

    The state at a stamp depends only on the messages with stamps up to it (and on the odometry just after it), not on
    their order of arrival, as long as they arrive within the history: the measurements of the last seconds are kept in
    the order of their stamps, with the filter state after each. A late message invalidates the states after it; they
    are computed again when a state is asked for.
    """

    def __init__(self, sources: Sequence[SourceSettings], settings: ArbiterSettings) -> None:
        """Start without a pose; the index of a source is its position in the sequence."""
        self.apply_settings(sources, settings)
        self._history_length = round(settings.history_seconds * 1e9)
        self.reset()

    def apply_settings(self, sources: Sequence[SourceSettings], settings: ArbiterSettings) -> None:
        """Process later poses with changed settings; states that are computed already stay."""
        self._settings = settings
        self._offsets = [SE2(*source.offset) for source in sources]
        self._sigmas = [diagonal(source.sigma_xy**2, source.sigma_yaw**2) for source in sources]
        self._rejection = OutlierRejection(sources, settings)

    def reset(self) -> None:
        """Clear the state, the measurements and the odometry."""
        self._odometry = OdometryBuffer(
            history=self._history_length, speed_max=self._settings.speed_max, turn_rate_max=self._settings.turn_rate_max
        )
        self._newest: int | None = None
        self._base = self._rejection.initial_state()  # state before the first measurement
        self._measurements: list[PoseMeasurement] = []
        self._results: list[tuple[FilterState, MeasurementStatus]] = []  # of the first measurements
        self._final_counts: Counter[tuple[int, MeasurementStatus]] = Counter()  # of dropped measurements

    def add_odometry(self, stamp: int, T_odom_base: SE2, now: int) -> RejectReason | None:
        """Add an odometry message.

        Args:
            stamp: stamp of the message [ns].
            T_odom_base: pose of the base in the odometry frame.
            now: current time [ns].

        Returns:
            the reason it was rejected, None if accepted.
        """
        reason = _validate_pose(T_odom_base) or self._validate_stamp(stamp, now)
        if reason is not None:
            return reason
        changed = self._odometry.add(stamp, T_odom_base)
        if changed is None:
            return RejectReason.DUPLICATE
        # The states after the message before it were predicted with other odometry.
        del self._results[bisect_left(self._measurements, (changed,)) :]
        self._advance(stamp)
        return None

    def add_pose(self, source: int, stamp: int, pose: SE2, noise: Covariance | None, now: int) -> RejectReason | None:
        """Add a pose of a source or of the `OPERATOR`.

        Args:
            source: source index.
            stamp: stamp of the message [ns].
            pose: pose in the map of the frame that the source localizes.
            noise: covariance of the pose; None uses the sigmas of the source.
            now: current time [ns].

        Returns:
            the reason it was rejected as invalid, else None. The gate is applied later, when a state is asked for.
        """
        if noise is None:
            noise = self._sigmas[source]
        reason = _validate_pose(pose) or _validate_covariance(noise) or self._validate_stamp(stamp, now)
        if reason is not None:
            return reason
        # Insert it by its stamp; the states after it are computed again.
        index = bisect_left(self._measurements, (stamp, source))
        if index < len(self._measurements) and self._measurements[index][:2] == (stamp, source):
            return RejectReason.DUPLICATE
        T_map_base = pose if source == OPERATOR else pose @ self._offsets[source]
        self._measurements.insert(index, PoseMeasurement(stamp, source, T_map_base, noise))
        del self._results[index:]
        self._advance(stamp)
        return None

    def state_at(self, stamp: int) -> FilterState:
        """Return the filter state at a stamp [ns] that is within the history or newer, after the poses up to it."""
        count = bisect_left(self._measurements, (stamp + 1,))
        self._process_pending(count)
        return self._results[count - 1][0] if count else self._base

    def estimate_at(self, stamp: int) -> Estimate | None:
        """Return the pose at a stamp [ns] that is within the history or newer, None before initialization."""
        estimate = self.state_at(stamp).estimate
        if estimate is None or estimate.odometry.stamp >= stamp:
            return estimate
        return predict(estimate, self._odometry.lookup(stamp), self._settings)

    def T_map_odom(self, estimate: Estimate) -> SE2 | None:  # noqa: N802
        """Return the pose of the odometry frame in the map at an estimate's stamp, None without odometry."""
        T_odom_base = self._odometry.pose_at(estimate.odometry.stamp)
        return None if isinstance(T_odom_base, NoPoseReason) else estimate.pose @ T_odom_base.inverse()

    def counts(self) -> Counter[tuple[int, MeasurementStatus]]:
        """Return the number of poses by (source index, status)."""
        self._process_pending(len(self._measurements))
        return self._final_counts + Counter(self._statuses(len(self._measurements)))

    @property
    def latest_odometry(self) -> int | None:
        """Stamp of the newest odometry [ns]."""
        return self._odometry.latest

    def _validate_stamp(self, stamp: int, now: int) -> RejectReason | None:
        if stamp <= 0:
            return RejectReason.NO_STAMP
        if stamp > now + _CLOCK_OFFSET_MAX:
            return RejectReason.FUTURE
        newest = now if self._newest is None else max(now, self._newest)
        return RejectReason.TOO_OLD if stamp < newest - self._history_length else None

    def _process_pending(self, count: int) -> None:
        """Process those of the first ``count`` poses that have no result yet."""
        for k in range(len(self._results), count):
            measurement = self._measurements[k]
            state = self._results[k - 1][0] if k else self._base
            odometry = self._odometry.lookup(measurement.stamp)
            self._results.append(self._rejection.process(state, measurement, odometry))

    def _advance(self, stamp: int) -> None:
        """Make the results of poses older than the history final and drop the poses."""
        if self._newest is not None and stamp <= self._newest:
            return
        self._newest = stamp
        old = bisect_left(self._measurements, (stamp - self._history_length,))
        if old:
            self._process_pending(old)
            self._base = self._results[old - 1][0]
            self._final_counts.update(self._statuses(old))
            del self._measurements[:old], self._results[:old]

    def _statuses(self, count: int) -> list[tuple[int, MeasurementStatus]]:
        """Return source index and status of the first ``count`` poses, which are processed."""
        return [(self._measurements[k].source, self._results[k][1]) for k in range(count)]


def _validate_pose(pose: SE2) -> RejectReason | None:
    """Return the reason a pose is invalid, None if it is valid."""
    if not (math.isfinite(pose.x) and math.isfinite(pose.y) and math.isfinite(pose.yaw)):
        return RejectReason.NOT_FINITE
    if max(abs(pose.x), abs(pose.y)) > _FARTHEST:
        return RejectReason.TOO_FAR
    return None


def _validate_covariance(noise: Covariance) -> RejectReason | None:
    """Return the reason a covariance is invalid, None if it is valid."""
    variances = noise.diagonal()
    is_plausible = variances.min() >= _VAR_MIN and (variances <= (_VAR_XY_MAX, _VAR_XY_MAX, _VAR_YAW_MAX)).all()
    return None if is_plausible and is_positive_definite(noise) else RejectReason.BAD_COVARIANCE
