"""One step of the filter with outlier rejection: from the state before a measurement to the state after it.

The step is a pure function, so that replayed measurements give the same result as measurements that came in order.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import NamedTuple

from scipy.special import gammaincinv

from pose_arbiter.core.arbiter_settings import ArbiterSettings
from pose_arbiter.core.covariance import (
    add_covariances,
    diagonal,
    inverse,
    mahalanobis_squared,
    scale_covariance,
)
from pose_arbiter.core.kalman_filter import (
    Estimate,
    compute_innovation,
    initialize,
    initialize_from_source,
    predict,
    update,
)
from pose_arbiter.core.measurement_status import MeasurementStatus
from pose_arbiter.core.pose_measurement import (
    PoseMeasurement,
    PoseWithOdometry,
    attach_odometry,
    is_consistent,
)
from pose_arbiter.core.source_settings import SourceSettings
from pose_arbiter.core.source_state import NEVER, SourceState, check_odometry_consistency
from shirube_core.motion import CumulativeOdometry, motion_between

_RESET_INFLATION = 4.0  # covariance factor of a pose that the estimate is reset to
_PROBATION_DISTANCE = 0.2  # robot motion during probation [m]; 1 rad counts as 1 m
_VOTES_NEW, _VOTES_ESTABLISHED = 2, 3  # two new sources outweigh an established one


class FilterState(NamedTuple):
    """State of the filter and of its sources at one stamp.

    Attributes:
        estimate: pose and biases, None before initialization.
        source_states: state of each source, by source index.
        first_stamp: stamp of the first pose that waits for initialization [ns].
        resets: number of resets of the estimate.
    """

    estimate: Estimate | None
    source_states: tuple[SourceState, ...]
    first_stamp: int = NEVER
    resets: int = 0


class OutlierRejection:
    """Gates measurements, updates or resets the estimate; holds only settings."""

    def __init__(self, sources: Sequence[SourceSettings], settings: ArbiterSettings) -> None:
        """Compute the gate and the timeouts.

        Args:
            sources: settings of each source, by source index.
            settings: filter settings.
        """
        self._sources, self._settings = tuple(sources), settings
        self._timeouts = tuple(round(source.timeout * 1e9) for source in sources)
        # Quantile of the chi-square distribution with 3 degrees of freedom.
        self._gate = float(2.0 * gammaincinv(1.5, settings.gate_probability))
        self._probation = round(settings.consistency_window * 1e9)
        self._start_wait = round(settings.start_seconds * 1e9)
        self._gate_margin = diagonal(settings.gate_margin_xy**2, settings.gate_margin_yaw**2)

    def initial_state(self) -> FilterState:
        """Return the state before the first measurement."""
        return FilterState(None, (SourceState(),) * len(self._sources))

    def process(
        self, state: FilterState, measurement: PoseMeasurement, odometry: CumulativeOdometry
    ) -> tuple[FilterState, MeasurementStatus]:
        """Process one measurement; return the state after it and the status of the measurement.

        Args:
            state: state before the measurement.
            measurement: pose, not older than the measurements before.
            odometry: cumulative odometry at its stamp.
        """
        if measurement.source < 0:
            return self._set_initial_pose(state, measurement, odometry), MeasurementStatus.RESET
        observed = attach_odometry(measurement, odometry)
        number = measurement.source
        source_state, is_consistent_motion = check_odometry_consistency(
            state.source_states[number], observed, self._gate, self._timeouts[number], self._settings
        )
        state = _with_source(state, number, source_state)
        # Odometry is wrong where two sources agree with each other but not with it.
        agreeing = [] if is_consistent_motion else self._agreeing_sources(state, number, observed)
        is_odometry_wrong = any(state.source_states[k].alternative is not None for k in agreeing)
        if not is_consistent_motion and not is_odometry_wrong:
            status, estimate = MeasurementStatus.ODOMETRY_INCONSISTENT, state.estimate
        elif state.estimate is None:
            status, estimate, state = self._initialize(state, measurement, observed)
        else:
            status, estimate = self._gate_and_update(
                state, measurement, observed, is_odometry_wrong=is_odometry_wrong
            )
        state = _with_source(state, number, source_state.record_status(status, odometry))
        resets = state.resets + (status is MeasurementStatus.RESET)
        return state._replace(estimate=estimate, resets=resets), status

    def _set_initial_pose(
        self, state: FilterState, measurement: PoseMeasurement, odometry: CumulativeOdometry
    ) -> FilterState:
        """Initialize from the operator's pose and clear the states of the sources."""
        estimate = initialize(
            odometry, measurement.x, measurement.y, measurement.yaw, measurement.noise, len(self._sources)
        )
        return FilterState(estimate, self.initial_state().source_states, NEVER, state.resets + 1)

    def _initialize(
        self, state: FilterState, measurement: PoseMeasurement, observed: PoseWithOdometry
    ) -> tuple[MeasurementStatus, Estimate | None, FilterState]:
        """Initialize where two sources agree, or from the best one if none agrees in time."""
        first = measurement.stamp if state.first_stamp == NEVER else state.first_stamp
        state = state._replace(first_stamp=first)
        is_only_source = len(self._sources) == 1
        if is_only_source or self._agreeing_sources(state, measurement.source, observed):
            return MeasurementStatus.RESET, self._reset_to(measurement, observed.odometry, 1.0), state
        is_best = self._best_source(state, measurement.stamp) == measurement.source
        if measurement.stamp - first >= self._start_wait and is_best:
            return MeasurementStatus.RESET, self._reset_to(measurement, observed.odometry, 1.0), state
        return MeasurementStatus.WAITING, None, state

    def _best_source(self, state: FilterState, stamp: int) -> int:
        """Return the fresh source with the highest priority, then with the longest consistent run."""
        ranked = [
            (source.priority, source_state.run_length, -number)
            for number, (source, source_state) in enumerate(
                zip(self._sources, state.source_states, strict=True)
            )
            if source_state.alternative is None and source_state.is_fresh(stamp, self._timeouts[number])
        ]
        return -max(ranked)[2] if ranked else -1

    def _gate_and_update(
        self,
        state: FilterState,
        measurement: PoseMeasurement,
        observed: PoseWithOdometry,
        *,
        is_odometry_wrong: bool,
    ) -> tuple[MeasurementStatus, Estimate]:
        """Update with a pose inside the gate; reset to a pose outside it that has enough support."""
        assert state.estimate is not None  # noqa: S101 for the type checker
        predicted = predict(state.estimate, observed.odometry, self._settings)
        if is_odometry_wrong:
            predicted = self._inflate_without_odometry(
                predicted, measurement.stamp - state.estimate.odometry.stamp
            )
        innovation = compute_innovation(predicted, measurement.x, measurement.y, measurement.yaw)
        innovation_covariance = add_covariances(
            add_covariances(predicted.covariance, measurement.noise), self._gate_margin
        )
        if mahalanobis_squared(innovation, inverse(innovation_covariance)) <= self._gate:
            if self._is_on_probation(state, measurement, observed.odometry):
                return MeasurementStatus.PROBATION, state.estimate
            bias_fraction = self._settings.bias_fraction
            return MeasurementStatus.USED, update(
                predicted, innovation, measurement.source, measurement.noise, bias_fraction
            )
        if self._can_reset(state, measurement, observed):
            return MeasurementStatus.RESET, self._reset_to(measurement, observed.odometry, _RESET_INFLATION)
        return MeasurementStatus.OUTSIDE_GATE, state.estimate

    def _reset_to(
        self, measurement: PoseMeasurement, odometry: CumulativeOdometry, inflation: float
    ) -> Estimate:
        noise = scale_covariance(measurement.noise, inflation)
        initial = initialize(
            odometry, measurement.x, measurement.y, measurement.yaw, noise, len(self._sources)
        )
        return initialize_from_source(
            initial, measurement.source, measurement.noise, self._settings.bias_fraction
        )

    def _is_on_probation(
        self, state: FilterState, measurement: PoseMeasurement, odometry: CumulativeOdometry
    ) -> bool:
        """Return whether a rejected source must stay inside the gate for longer before it is accepted again.

        A source that drifts away passes the gate now and then. If it were accepted at once, it would pull the pose as
        soon as the other sources pause. While the robot is stationary, a frozen or late source is inside the gate, too:
        so the robot must also have moved.
        """
        source_state = state.source_states[measurement.source]
        if source_state.rejected_count < self._settings.reset_count:
            return False
        near = source_state.inside_gate_since
        is_too_short = (
            near is None
            or measurement.stamp - near.stamp < self._probation
            or motion_between(near, odometry).path_length(self._settings.drift_speed) < _PROBATION_DISTANCE
        )
        others = (k for k in range(len(state.source_states)) if k != measurement.source)
        return is_too_short and any(
            state.source_states[k].is_supporting(measurement.stamp, self._timeouts[k]) for k in others
        )

    def _inflate_without_odometry(self, predicted: Estimate, nanoseconds: int) -> Estimate:
        """Return the estimate with its covariance inflated as if there were no odometry."""
        xy, yaw = (
            (speed * nanoseconds * 1e-9) ** 2
            for speed in (self._settings.drift_speed, self._settings.drift_turn_rate)
        )
        P = predicted.P.copy()
        P[[0, 1, 2], [0, 1, 2]] += (xy, xy, yaw)
        return predicted._replace(P=P)

    def _can_reset(
        self, state: FilterState, measurement: PoseMeasurement, observed: PoseWithOdometry
    ) -> bool:
        """Return whether the estimate is reset to a pose outside the gate.

        Enough consistent poses must have been rejected. One source alone then resets the estimate if no source, itself
        included, supported it within the timeout; or if it is established and the supporters are not. Two sources that
        agree reset it if they outvote the supporters.
        """
        agreeing = self._agreeing_sources(state, measurement.source, observed)
        challengers = [
            measurement.source,
            *(k for k in agreeing if state.source_states[k].status is MeasurementStatus.OUTSIDE_GATE),
        ]
        rejected = sum(state.source_states[k].rejected_count for k in challengers) + 1
        if rejected < self._settings.reset_count:
            return False
        supporting = [
            k
            for k, source_state in enumerate(state.source_states)
            if source_state.is_supporting(measurement.stamp, self._timeouts[k])
        ]
        supporters = [
            k
            for k in supporting
            if k not in challengers and state.source_states[k].status is MeasurementStatus.USED
        ]
        is_outvoted = self._count_votes(state, challengers) > self._count_votes(state, supporters)
        return not supporting or (is_outvoted and (len(challengers) > 1 or bool(supporters)))

    def _count_votes(self, state: FilterState, numbers: Sequence[int]) -> int:
        enough = self._settings.established_count
        return sum(
            _VOTES_ESTABLISHED if state.source_states[k].accepted_count >= enough else _VOTES_NEW
            for k in numbers
        )

    def _agreeing_sources(self, state: FilterState, number: int, observed: PoseWithOdometry) -> list[int]:
        """Return the other sources whose latest pose is fresh and consistent with this one."""
        return [
            k
            for k, source_state in enumerate(state.source_states)
            if k != number
            and source_state.latest is not None
            and source_state.is_fresh(observed.odometry.stamp, self._timeouts[k])
            and is_consistent(source_state.latest, observed, self._gate, self._settings)
        ]


def _with_source(state: FilterState, number: int, source_state: SourceState) -> FilterState:
    source_states = state.source_states
    return state._replace(source_states=(*source_states[:number], source_state, *source_states[number + 1 :]))
