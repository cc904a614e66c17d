"""One step of the filter with outlier rejection: from the state before a measurement to the state after it.

The step is a pure function, so that replayed measurements give the same result as measurements that came in order.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import NamedTuple

from scipy.special import gammaincinv

from pose_arbiter.core.arbiter_settings import ArbiterSettings
from pose_arbiter.core.covariance import added, diagonal, distance_squared, inverse, scaled
from pose_arbiter.core.estimate import Estimate, measured, mended, moved_on, residual, told
from pose_arbiter.core.odometry_mark import OdometryMark, motion_between
from pose_arbiter.core.sighting import Observation, Sighting, same_robot, sighting_of
from pose_arbiter.core.source_record import NEVER, SourceRecord, witnessed
from pose_arbiter.core.source_settings import SourceSettings
from pose_arbiter.core.verdict import Verdict

_INFLATION = 4.0  # covariance factor of a pose that the estimate is reset to
_PROBATION_WAY = 0.2  # robot motion during probation [m]; 1 rad counts as 1 m
_WORD_OF_NEW, _WORD_OF_ESTABLISHED = 2, 3  # two new sources outweigh an established one


class Belief(NamedTuple):
    """State of the filter and of its sources at one stamp.

    Attributes:
        estimate: pose and biases, None before initialization.
        source_states: state of each source, by source index.
        first_stamp: stamp of the first pose that waits for initialization [ns].
        resets: number of resets of the estimate.
    """

    estimate: Estimate | None
    records: tuple[SourceRecord, ...]
    first_stamp: int = NEVER
    resets: int = 0


class Judge:
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
        self._probation = round(settings.witness_seconds * 1e9)
        self._start_wait = round(settings.start_seconds * 1e9)
        self._slack = diagonal(settings.slack_xy**2, settings.slack_yaw**2)

    def beginning(self) -> Belief:
        """Return the state before the first measurement."""
        return Belief(None, (SourceRecord(),) * len(self._sources))

    def judge(self, belief: Belief, pose: Observation, mark: OdometryMark) -> tuple[Belief, Verdict]:
        """Process one measurement; return the state after it and the status of the measurement.

        Args:
            state: state before the measurement.
            measurement: pose, not older than the measurements before.
            odometry: cumulative odometry at its stamp.
        """
        if pose.source < 0:
            return self._told(belief, pose, mark), Verdict.RESET
        seen = sighting_of(pose, mark)
        number = pose.source
        record, moves_alike = witnessed(
            belief.records[number], seen, self._gate, self._timeouts[number], self._settings
        )
        belief = _with_record(belief, number, record)
        # Odometry is wrong where two sources agree with each other but not with it.
        against = [] if moves_alike else self._seconds(belief, number, seen)
        is_blind = any(belief.records[k].rival is not None for k in against)
        if not moves_alike and not is_blind:
            verdict, estimate = Verdict.MOVES_OTHERWISE, belief.estimate
        elif belief.estimate is None:
            verdict, estimate, belief = self._start(belief, pose, seen)
        else:
            verdict, estimate = self._weigh(belief, pose, seen, is_blind=is_blind)
        belief = _with_record(belief, number, record.judged(verdict, mark))
        resets = belief.resets + (verdict is Verdict.RESET)
        return belief._replace(estimate=estimate, resets=resets), verdict

    def _told(self, belief: Belief, pose: Observation, mark: OdometryMark) -> Belief:
        """Initialize from the operator's pose and clear the states of the sources."""
        estimate = told(mark, pose.x, pose.y, pose.yaw, pose.noise, len(self._sources))
        return Belief(estimate, self.beginning().records, NEVER, belief.resets + 1)

    def _start(
        self, belief: Belief, pose: Observation, seen: Sighting
    ) -> tuple[Verdict, Estimate | None, Belief]:
        """Initialize where two sources agree, or from the best one if none agrees in time."""
        first = pose.stamp if belief.first_stamp == NEVER else belief.first_stamp
        belief = belief._replace(first_stamp=first)
        alone = len(self._sources) == 1
        if alone or self._seconds(belief, pose.source, seen):
            return Verdict.RESET, self._set_to(pose, seen.mark, 1.0), belief
        is_best = self._best(belief, pose.stamp) == pose.source
        if pose.stamp - first >= self._start_wait and is_best:
            return Verdict.RESET, self._set_to(pose, seen.mark, 1.0), belief
        return Verdict.WAITS, None, belief

    def _best(self, belief: Belief, stamp: int) -> int:
        """Return the fresh source with the highest priority, then with the longest consistent run."""
        ranked = [
            (source.priority, record.chain, -number)
            for number, (source, record) in enumerate(zip(self._sources, belief.records, strict=True))
            if record.rival is None and record.speaks(stamp, self._timeouts[number])
        ]
        return -max(ranked)[2] if ranked else -1

    def _weigh(
        self, belief: Belief, pose: Observation, seen: Sighting, *, is_blind: bool
    ) -> tuple[Verdict, Estimate]:
        """Update with a pose inside the gate; reset to a pose outside it that has enough support."""
        assert belief.estimate is not None  # noqa: S101 for the type checker
        expected = moved_on(belief.estimate, seen.mark, self._settings)
        if is_blind:
            expected = self._without_odometry(expected, pose.stamp - belief.estimate.mark.stamp)
        difference = residual(expected, pose.x, pose.y, pose.yaw)
        innovation = added(added(expected.covariance, pose.noise), self._slack)
        if distance_squared(difference, inverse(innovation)) <= self._gate:
            if self._is_on_probation(belief, pose, seen.mark):
                return Verdict.PROBATION, belief.estimate
            share = self._settings.lasting_share
            return Verdict.USED, mended(expected, difference, pose.source, pose.noise, share)
        if self._outweighs(belief, pose, seen):
            return Verdict.RESET, self._set_to(pose, seen.mark, _INFLATION)
        return Verdict.GATED, belief.estimate

    def _set_to(self, pose: Observation, mark: OdometryMark, inflation: float) -> Estimate:
        noise = scaled(pose.noise, inflation)
        begin = told(mark, pose.x, pose.y, pose.yaw, noise, len(self._sources))
        return measured(begin, pose.source, pose.noise, self._settings.lasting_share)

    def _is_on_probation(self, belief: Belief, pose: Observation, mark: OdometryMark) -> bool:
        """Return whether a rejected source must stay inside the gate for longer before it is accepted again.

        A source that drifts away passes the gate now and then. If it were accepted at once, it would pull the pose as
        soon as the other sources pause. While the robot is stationary, a frozen or late source is inside the gate, too:
        so the robot must also have moved.
        """
        record = belief.records[pose.source]
        if record.gated < self._settings.reset_count:
            return False
        near = record.near_since
        is_short = (
            near is None
            or pose.stamp - near.stamp < self._probation
            or motion_between(near, mark).moved(self._settings.drift_speed) < _PROBATION_WAY
        )
        others = (k for k in range(len(belief.records)) if k != pose.source)
        return is_short and any(belief.records[k].stands_by(pose.stamp, self._timeouts[k]) for k in others)

    def _without_odometry(self, expected: Estimate, nanoseconds: int) -> Estimate:
        """Return the estimate with its covariance inflated as if there were no odometry."""
        xy, yaw = (
            (speed * nanoseconds * 1e-9) ** 2
            for speed in (self._settings.drift_speed, self._settings.drift_turn_rate)
        )
        P = expected.P.copy()
        P[[0, 1, 2], [0, 1, 2]] += (xy, xy, yaw)
        return expected._replace(P=P)

    def _outweighs(self, belief: Belief, pose: Observation, seen: Sighting) -> bool:
        """Return whether the estimate is reset to a pose outside the gate.

        Enough consistent poses must have been rejected. One source alone then resets the estimate if no source, itself
        included, supported it within the timeout; or if it is established and the supporters are not. Two sources that
        agree reset it if they outvote the supporters.
        """
        agreeing = self._seconds(belief, pose.source, seen)
        challengers = [pose.source, *(k for k in agreeing if belief.records[k].verdict is Verdict.GATED)]
        refused = sum(belief.records[k].gated for k in challengers) + 1
        if refused < self._settings.reset_count:
            return False
        supporting = [
            k for k, record in enumerate(belief.records) if record.stands_by(pose.stamp, self._timeouts[k])
        ]
        supporters = [
            k for k in supporting if k not in challengers and belief.records[k].verdict is Verdict.USED
        ]
        is_outvoted = self._weight(belief, challengers) > self._weight(belief, supporters)
        return not supporting or (is_outvoted and (len(challengers) > 1 or bool(supporters)))

    def _weight(self, belief: Belief, numbers: Sequence[int]) -> int:
        enough = self._settings.established_count
        return sum(
            _WORD_OF_ESTABLISHED if belief.records[k].standing >= enough else _WORD_OF_NEW for k in numbers
        )

    def _seconds(self, belief: Belief, number: int, seen: Sighting) -> list[int]:
        """Return the other sources whose latest pose is fresh and consistent with this one."""
        return [
            k
            for k, record in enumerate(belief.records)
            if k != number
            and record.latest is not None
            and record.speaks(seen.mark.stamp, self._timeouts[k])
            and same_robot(record.latest, seen, self._gate, self._settings)
        ]


def _with_record(belief: Belief, number: int, record: SourceRecord) -> Belief:
    records = belief.records
    return belief._replace(records=(*records[:number], record, *records[number + 1 :]))
