"""State of one source, and the consistency check of its motion with odometry."""

from __future__ import annotations

from typing import NamedTuple

from pose_arbiter.core.arbiter_settings import ArbiterSettings
from pose_arbiter.core.odometry_mark import OdometryMark
from pose_arbiter.core.sighting import Sighting, same_robot
from pose_arbiter.core.verdict import Verdict

NEVER = -(2**62)
"""A stamp before all others [ns]."""
_STANDING_MAX = 100_000


class SourceRecord(NamedTuple):
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

    latest: Sighting | None = None
    anchor: Sighting | None = None
    next_anchor: Sighting | None = None
    rival: Sighting | None = None
    rivals: int = 0
    chain: int = 0
    gated: int = 0
    near_since: OdometryMark | None = None
    standing: int = 0
    used_stamp: int = NEVER
    verdict: Verdict | None = None

    def speaks(self, stamp: int, timeout: int) -> bool:
        """Return whether its latest pose is not older than the timeout [ns]."""
        return self.latest is not None and stamp - self.latest.mark.stamp <= timeout

    def stands_by(self, stamp: int, timeout: int) -> bool:
        """Return whether a pose of it was accepted within the timeout [ns]."""
        return stamp - self.used_stamp <= timeout

    def judged(self, verdict: Verdict, mark: OdometryMark) -> SourceRecord:
        """Return the source state after a measurement of this status, with the odometry at its stamp."""
        if verdict in (Verdict.USED, Verdict.RESET):
            standing = min(self.standing + 1, _STANDING_MAX)
            return self._replace(
                verdict=verdict, gated=0, near_since=None, standing=standing, used_stamp=mark.stamp
            )
        if verdict is Verdict.GATED:
            return self._replace(verdict=verdict, gated=self.gated + 1, near_since=None)
        if verdict is Verdict.PROBATION and self.near_since is None:
            return self._replace(verdict=verdict, near_since=mark)
        return self._replace(verdict=verdict)


def witnessed(
    record: SourceRecord, seen: Sighting, gate: float, timeout: int, settings: ArbiterSettings
) -> tuple[SourceRecord, bool]:
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
    stamp, window = seen.mark.stamp, round(settings.witness_seconds * 1e9)
    is_first = record.anchor is None or not record.speaks(stamp, max(timeout, window))
    updated = record._replace(latest=seen, rival=None, rivals=0)
    if is_first:
        return updated._replace(anchor=seen, next_anchor=seen, chain=1), True
    anchor, next_anchor = record.anchor, record.next_anchor
    assert anchor is not None  # noqa: S101 for the type checker
    assert next_anchor is not None  # noqa: S101
    if same_robot(anchor, seen, gate, settings):
        if stamp - next_anchor.mark.stamp > window // 2:
            anchor, next_anchor = next_anchor, seen
        return updated._replace(anchor=anchor, next_anchor=next_anchor, chain=record.chain + 1), True
    if record.rival is None or not same_robot(record.rival, seen, gate, settings):
        return record._replace(latest=seen, rival=seen, rivals=1), False
    rivals = record.rivals + 1
    if rivals < settings.reset_count or stamp - record.rival.mark.stamp < window // 2:
        return record._replace(latest=seen, rivals=rivals), False
    return updated._replace(anchor=record.rival, next_anchor=seen, chain=rivals, standing=0), True
