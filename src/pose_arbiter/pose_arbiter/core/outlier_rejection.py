"""One step of the filter with outlier rejection: from the state before a measurement to the state after it.

The step is a pure function, so that replayed measurements give the same result as measurements that came in order.
"""

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np
from scipy.special import gammaincinv

from pose_arbiter.core.kalman_filter import (
    Estimate,
    compute_innovation,
    diagonal,
    initialize,
    initialize_from_source,
    predict,
    update,
)
from pose_arbiter.core.settings import ArbiterSettings, SourceSettings
from pose_arbiter.core.source_state import (
    NEVER,
    MeasurementStatus,
    PoseMeasurement,
    PoseWithOdometry,
    SourceState,
    attach_odometry,
    check_odometry_consistency,
    is_consistent,
)
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
        """Compute the gate and the timeouts; the index of a source is its position in the sequence."""
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
        """Process one measurement; return the state after it and the status of the measurement."""
        number = measurement.source
        # An operator's pose initializes the filter; the sources begin anew.
        if number < 0:
            initial = initialize(odometry, measurement.pose, measurement.noise, len(self._sources))
            reset = self.initial_state()._replace(estimate=initial, resets=state.resets + 1)
            return reset, MeasurementStatus.RESET
        # 1. Does odometry lead from the source's earlier poses to this one?
        observed = attach_odometry(measurement, odometry)
        source_state, is_consistent_motion = check_odometry_consistency(
            state.source_states[number], observed, self._gate, self._timeouts[number], self._settings
        )
        state = _with_source(state, number, source_state)
        # Odometry is wrong, the wheels slip, where two sources agree with each other but not with it.
        agreeing = [] if is_consistent_motion else self._agreeing_sources(state, number, observed)
        is_slipping = any(state.source_states[k].alternative is not None for k in agreeing)
        if not is_consistent_motion and not is_slipping:
            status, estimate = MeasurementStatus.ODOMETRY_INCONSISTENT, state.estimate
        # 2. At the start: initialize where two sources agree, or from the best one if none agrees in time.
        elif state.estimate is None:
            first = measurement.stamp if state.first_stamp == NEVER else state.first_stamp
            state, status, estimate = state._replace(first_stamp=first), MeasurementStatus.WAITING, None
            if self._can_initialize(state, measurement, observed):
                status, estimate = MeasurementStatus.RESET, self._reset_to(measurement, odometry, 1.0)
        # 3. Later: predict, then update with a pose inside the gate or reset to one with enough support.
        else:
            predicted = self._predict(state.estimate, odometry, is_slipping=is_slipping)
            status, updated = self._gate_and_update(state, predicted, measurement, observed)
            estimate = state.estimate if updated is None else updated
        # 4. Record the status of the source.
        state = _with_source(state, number, source_state.record_status(status, odometry))
        resets = state.resets + (status is MeasurementStatus.RESET)
        return state._replace(estimate=estimate, resets=resets), status

    def _predict(self, estimate: Estimate, odometry: CumulativeOdometry, *, is_slipping: bool) -> Estimate:
        """Predict; while the wheels slip, inflate the covariance as if there were no odometry."""
        predicted = predict(estimate, odometry, self._settings)
        if not is_slipping:
            return predicted
        seconds = (odometry.stamp - estimate.odometry.stamp) * 1e-9
        xy, yaw = self._settings.drift_speed * seconds, self._settings.drift_turn_rate * seconds
        P = predicted.P.copy()
        P[[0, 1, 2], [0, 1, 2]] += (xy**2, xy**2, yaw**2)
        return predicted._replace(P=P)

    def _gate_and_update(
        self, state: FilterState, predicted: Estimate, measurement: PoseMeasurement, observed: PoseWithOdometry
    ) -> tuple[MeasurementStatus, Estimate | None]:
        """Return the status of a measurement and the new estimate, None for a rejected measurement."""
        # Gate: innovation d, covariances of the pose, the measurement and the margin, dᵀ (T + R + S)⁻¹ d.
        innovation = compute_innovation(predicted, measurement.pose)
        covariance = predicted.covariance + measurement.noise + self._gate_margin
        if innovation @ np.linalg.solve(covariance, innovation) > self._gate:
            # Outside: the robot was moved, or the estimate is wrong, if the pose has enough support.
            if self._can_reset(state, measurement, observed):
                return MeasurementStatus.RESET, self._reset_to(measurement, observed.odometry, _RESET_INFLATION)
            return MeasurementStatus.OUTSIDE_GATE, None
        # Inside: a source that was rejected must stay inside for a while.
        if self._is_on_probation(state, measurement, observed.odometry):
            return MeasurementStatus.PROBATION, None
        # Update of pose and biases.
        bias_fraction = self._settings.bias_fraction
        return MeasurementStatus.USED, update(
            predicted, innovation, measurement.source, measurement.noise, bias_fraction
        )

    def _can_initialize(self, state: FilterState, measurement: PoseMeasurement, observed: PoseWithOdometry) -> bool:
        """Return whether another source agrees, or no other one can, or this is the best one after the wait."""
        if len(self._sources) == 1 or self._agreeing_sources(state, measurement.source, observed):
            return True
        if measurement.stamp - state.first_stamp < self._start_wait:
            return False
        # The best: fresh, with the highest priority, then with the longest consistent run.
        ranked = [
            (source.priority, source_state.run_length, -number)
            for number, (source, source_state) in enumerate(zip(self._sources, state.source_states, strict=True))
            if source_state.alternative is None and source_state.is_fresh(measurement.stamp, self._timeouts[number])
        ]
        return bool(ranked) and max(ranked)[2] == -measurement.source

    def _reset_to(self, measurement: PoseMeasurement, odometry: CumulativeOdometry, inflation: float) -> Estimate:
        initial = initialize(odometry, measurement.pose, inflation * measurement.noise, len(self._sources))
        return initialize_from_source(initial, measurement.source, measurement.noise, self._settings.bias_fraction)

    def _is_on_probation(self, state: FilterState, measurement: PoseMeasurement, odometry: CumulativeOdometry) -> bool:
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
        supporting = self._supporting_sources(state, measurement.stamp)
        return is_too_short and any(k != measurement.source for k in supporting)

    def _can_reset(self, state: FilterState, measurement: PoseMeasurement, observed: PoseWithOdometry) -> bool:
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
        supporting = self._supporting_sources(state, measurement.stamp)
        supporters = [
            k for k in supporting if k not in challengers and state.source_states[k].status is MeasurementStatus.USED
        ]
        is_outvoted = self._count_votes(state, challengers) > self._count_votes(state, supporters)
        return not supporting or (is_outvoted and (len(challengers) > 1 or bool(supporters)))

    def _count_votes(self, state: FilterState, numbers: Sequence[int]) -> int:
        enough = self._settings.established_count
        return sum(
            _VOTES_ESTABLISHED if state.source_states[k].accepted_count >= enough else _VOTES_NEW for k in numbers
        )

    def _supporting_sources(self, state: FilterState, stamp: int) -> list[int]:
        """Return the sources that supported the estimate within their timeouts."""
        return [k for k, s in enumerate(state.source_states) if s.is_supporting(stamp, self._timeouts[k])]

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
