"""State of one source, and the consistency check of its motion with odometry."""

from __future__ import annotations

import math
from enum import Enum
from typing import NamedTuple

from pose_arbiter.core.kalman_filter import Covariance
from pose_arbiter.core.settings import ArbiterSettings
from shirube_core.geometry import SE2
from shirube_core.motion import CumulativeOdometry, motion_between


class MeasurementStatus(Enum):
    """Result of outlier rejection for one pose; the value is the text of the diagnostics."""

    USED = 'used'
    RESET = 'estimate reset to it'
    WAITING = 'waiting for a second source at start'
    OUTSIDE_GATE = 'outside the gate'
    PROBATION = 'inside the gate again, on probation'
    ODOMETRY_INCONSISTENT = 'inconsistent with odometry'


class RejectReason(Enum):
    """Why a message is rejected before the filter; the value is the text of the diagnostics."""

    NOT_FINITE = 'not finite'
    TOO_FAR = 'farther than 1000 km from the origin'
    BAD_COVARIANCE = 'covariance is invalid'
    NO_STAMP = 'stamp is 0'
    FUTURE = 'stamp is in the future'
    TOO_OLD = 'stamp is too old'
    DUPLICATE = 'duplicate stamp'


class PoseMeasurement(NamedTuple):
    """A measured pose. Measurements are processed in the sort order of this tuple.

    Attributes:
        stamp: stamp [ns].
        source: source index; -1 is a pose set by an operator.
        pose: ``T_map_base``.
        noise: covariance R of the measurement.
    """

    stamp: int
    source: int
    pose: SE2
    noise: Covariance


NEVER = -(2**62)
"""A stamp before all others [ns]."""
_ACCEPTED_COUNT_MAX = 100_000


class PoseWithOdometry(NamedTuple):
    """A measured pose with the odometry at its stamp.

    Attributes:
        odometry: cumulative odometry at its stamp.
        x, y, yaw: ``T_map_base`` [m, rad].
        var_xy, var_yaw: larger of the variances of x and y [m²], and variance of yaw [rad²].
    """

    odometry: CumulativeOdometry
    x: float
    y: float
    yaw: float
    var_xy: float
    var_yaw: float


def attach_odometry(measurement: PoseMeasurement, odometry: CumulativeOdometry) -> PoseWithOdometry:
    """Return a measurement with the odometry at its stamp."""
    pose, (var_x, var_y, var_yaw) = measurement.pose, measurement.noise.diagonal().tolist()
    return PoseWithOdometry(odometry, pose.x, pose.y, pose.yaw, max(var_x, var_y), var_yaw)


def is_consistent(a: PoseWithOdometry, b: PoseWithOdometry, gate: float, settings: ArbiterSettings) -> bool:
    """Return whether odometry leads from a to b, within their variances and the odometry errors (chi-square gate).

    For yaw, both the systematic and the random odometry error count; the random one is larger over a short distance.
    For distance only the systematic one counts, so that a frozen source is detected even when the robot moves slowly.
    """
    if b.odometry.stamp < a.odometry.stamp:
        a, b = b, a
    motion = motion_between(a.odometry, b.odometry)
    yaw_offset = a.yaw - a.odometry.yaw
    cos, sin = math.cos(yaw_offset), math.sin(yaw_offset)
    x = b.x - a.x - cos * motion.x + sin * motion.y
    y = b.y - a.y - sin * motion.x - cos * motion.y
    yaw = math.remainder(b.yaw - a.yaw - motion.yaw, math.tau)
    chord_squared = motion.x * motion.x + motion.y * motion.y
    path_length = motion.distance + motion.rotation
    yaw_bias = settings.odometry_bias * path_length
    yaw_noise_var = settings.odometry_noise_yaw**2 * path_length
    yaw_bias_var = yaw_bias * yaw_bias + (settings.drift_turn_rate * motion.odometry_gap) ** 2
    var_yaw = a.var_yaw + b.var_yaw + settings.gate_margin_yaw**2 + yaw_bias_var + yaw_noise_var
    var_xy = (
        a.var_xy
        + b.var_xy
        + settings.gate_margin_xy**2
        + (settings.odometry_bias * motion.distance) ** 2
        + (settings.drift_speed * motion.odometry_gap) ** 2
        + chord_squared * (a.var_yaw + yaw_bias_var)
    )
    return (x * x + y * y) / var_xy + yaw * yaw / var_yaw <= gate


class SourceState(NamedTuple):
    """What outlier rejection keeps of a source between its poses.

    Attributes:
        latest: latest pose.
        reference: pose with which the next ones are compared by odometry.
        next_reference: pose that replaces the reference when that is too old.
        alternative: first pose of the alternative hypothesis, inconsistent with the reference.
        alternative_count: number of poses consistent with the alternative hypothesis.
        run_length: number of successive poses consistent with each other by odometry.
        rejected_count: number of poses outside the gate since the last accepted one.
        inside_gate_since: odometry at the first pose of the current run inside the gate, while on probation.
        accepted_count: number of accepted poses since the source was last found inconsistent.
        accepted_stamp: stamp of the latest accepted pose [ns].
        status: status of the latest pose.
    """

    latest: PoseWithOdometry | None = None
    reference: PoseWithOdometry | None = None
    next_reference: PoseWithOdometry | None = None
    alternative: PoseWithOdometry | None = None
    alternative_count: int = 0
    run_length: int = 0
    rejected_count: int = 0
    inside_gate_since: CumulativeOdometry | None = None
    accepted_count: int = 0
    accepted_stamp: int = NEVER
    status: MeasurementStatus | None = None

    def is_fresh(self, stamp: int, timeout: int) -> bool:
        """Return whether its latest pose is not older than the timeout [ns]."""
        return self.latest is not None and stamp - self.latest.odometry.stamp <= timeout

    def is_supporting(self, stamp: int, timeout: int) -> bool:
        """Return whether a pose of it was accepted within the timeout [ns]."""
        return stamp - self.accepted_stamp <= timeout

    def record_status(self, status: MeasurementStatus, odometry: CumulativeOdometry) -> SourceState:
        """Return the source state after a measurement of this status, with the odometry at its stamp."""
        if status in (MeasurementStatus.USED, MeasurementStatus.RESET):
            accepted_count = min(self.accepted_count + 1, _ACCEPTED_COUNT_MAX)
            return self._replace(
                status=status,
                rejected_count=0,
                inside_gate_since=None,
                accepted_count=accepted_count,
                accepted_stamp=odometry.stamp,
            )
        if status is MeasurementStatus.OUTSIDE_GATE:
            return self._replace(status=status, rejected_count=self.rejected_count + 1, inside_gate_since=None)
        if status is MeasurementStatus.PROBATION and self.inside_gate_since is None:
            return self._replace(status=status, inside_gate_since=odometry)
        return self._replace(status=status)


def check_odometry_consistency(
    source: SourceState, observed: PoseWithOdometry, gate: float, timeout: int, settings: ArbiterSettings
) -> tuple[SourceState, bool]:
    """Compare a source's new pose with its earlier ones by odometry.

    A single inconsistent pose is ignored. If inconsistent poses agree with each other for long enough, they become the
    reference: the source, or the robot, was moved.

    Args:
        source: state of the source.
        observed: new pose of the source.
        gate: chi-square threshold.
        timeout: the comparison restarts after a pause longer than this [ns].
        settings: filter settings.

    Returns:
        the state of the source, and whether its motion is consistent with odometry.
    """
    stamp, window = observed.odometry.stamp, round(settings.consistency_window * 1e9)
    is_new = source.reference is None or not source.is_fresh(stamp, max(timeout, window))
    updated = source._replace(latest=observed, alternative=None, alternative_count=0)
    if is_new:
        return updated._replace(reference=observed, next_reference=observed, run_length=1), True
    reference, next_reference = source.reference, source.next_reference
    assert reference is not None  # noqa: S101 for the type checker
    assert next_reference is not None  # noqa: S101
    if is_consistent(reference, observed, gate, settings):
        if stamp - next_reference.odometry.stamp > window // 2:
            reference, next_reference = next_reference, observed
        return updated._replace(
            reference=reference, next_reference=next_reference, run_length=source.run_length + 1
        ), True
    if source.alternative is None or not is_consistent(source.alternative, observed, gate, settings):
        return source._replace(latest=observed, alternative=observed, alternative_count=1), False
    alternative_count = source.alternative_count + 1
    if alternative_count < settings.reset_count or stamp - source.alternative.odometry.stamp < window // 2:
        return source._replace(latest=observed, alternative_count=alternative_count), False
    return updated._replace(
        reference=source.alternative, next_reference=observed, run_length=alternative_count, accepted_count=0
    ), True
