"""What is remembered of a source, and whether it moves as odometry does."""

from __future__ import annotations

from typing import NamedTuple

from pose_arbiter.core.arbiter_settings import ArbiterSettings
from pose_arbiter.core.odometry_mark import OdometryMark
from pose_arbiter.core.sighting import Sighting, same_robot
from pose_arbiter.core.verdict import Verdict

NEVER = -(2**62)
"""A stamp before all others."""
_STANDING_MAX = 100_000


class SourceRecord(NamedTuple):
    """A source's past, as far as it bears on the next judgement.

    Attributes:
        latest: its latest pose.
        anchor: the pose with which the next ones are compared by odometry.
        next_anchor: takes the anchor's place when that is too old.
        rival: first of the poses that odometry does not lead to from the anchor.
        rivals: how many poses agree with the rival, since it came.
        chain: how many poses agree with each other, by odometry.
        gated: how many were too far from the pose since the last one that was used.
        near_since: odometry at the first pose since then from which on none was too far.
        standing: how many were used since it was last found wrong.
        used_stamp: of the latest that was used [ns].
        verdict: of the latest.
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
        """Return whether it said something within its timeout [ns]."""
        return self.latest is not None and stamp - self.latest.mark.stamp <= timeout

    def stands_by(self, stamp: int, timeout: int) -> bool:
        """Return whether it agreed with the pose within its timeout [ns]."""
        return stamp - self.used_stamp <= timeout

    def judged(self, verdict: Verdict, mark: OdometryMark) -> SourceRecord:
        """Return the record after a judgement of a pose, with odometry at its stamp."""
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

    One pose that does not fit is left out. If those that do not fit agree with each other for long enough, it is they
    that count from then on: the source, or the robot, is elsewhere now.

    Args:
        record: of the source.
        seen: its new pose.
        gate: chi-square.
        timeout: after so long a silence there is nothing to compare with [ns].
        settings: of the method.

    Returns:
        the record, and whether the source moves as odometry does.
    """
    stamp, window = seen.mark.stamp, round(settings.witness_seconds * 1e9)
    is_first = record.anchor is None or not record.speaks(stamp, max(timeout, window))
    if is_first:
        return record._replace(
            latest=seen, anchor=seen, next_anchor=seen, rival=None, rivals=0, chain=1
        ), True
    anchor, next_anchor = record.anchor, record.next_anchor
    assert anchor is not None  # noqa: S101 for the type checker
    assert next_anchor is not None  # noqa: S101
    if same_robot(anchor, seen, gate, settings):
        if stamp - next_anchor.mark.stamp > window // 2:
            anchor, next_anchor = next_anchor, seen
        chain = record.chain + 1
        return record._replace(
            latest=seen, anchor=anchor, next_anchor=next_anchor, rival=None, rivals=0, chain=chain
        ), True
    if record.rival is None or not same_robot(record.rival, seen, gate, settings):
        return record._replace(latest=seen, rival=seen, rivals=1), False
    rivals = record.rivals + 1
    if rivals < settings.reset_count or stamp - record.rival.mark.stamp < window // 2:
        return record._replace(latest=seen, rivals=rivals), False
    return record._replace(
        latest=seen, anchor=record.rival, next_anchor=seen, rival=None, rivals=0, chain=rivals, standing=0
    ), True
