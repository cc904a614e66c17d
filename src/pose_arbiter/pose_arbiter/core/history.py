"""The measurements of the last seconds in the order of their stamps, with the filter state after each."""

from __future__ import annotations

from bisect import bisect_left
from collections import Counter

from pose_arbiter.core.judge import Belief, Judge
from pose_arbiter.core.odometry_trail import OdometryTrail
from pose_arbiter.core.sighting import Observation
from pose_arbiter.core.verdict import Verdict


class History:
    """Rewinds to a late measurement and replays those after it; computes only when a state is asked for."""

    def __init__(self, rejection: Judge, trail: OdometryTrail) -> None:
        """Start without measurements.

        Args:
            rejection: one filter step with outlier rejection.
            odometry: odometry buffer, filled by the owner, who calls `invalidate_from` when it changed.
        """
        self._judge, self._trail = rejection, trail
        self._base = rejection.beginning()  # state before the first measurement
        self._poses: list[Observation] = []
        self._outcomes: list[tuple[Belief, Verdict]] = []  # of processed measurements
        self._past: Counter[tuple[int, Verdict]] = Counter()  # of dropped measurements

    def has(self, stamp: int, source: int) -> bool:
        """Return whether the history contains a pose of that stamp [ns] and source."""
        place = bisect_left(self._poses, (stamp, source))
        return place < len(self._poses) and self._poses[place][:2] == (stamp, source)

    def add(self, pose: Observation) -> None:
        """Insert a pose by stamp; those after it are processed again."""
        place = bisect_left(self._poses, pose)
        self._poses.insert(place, pose)
        del self._outcomes[place:]

    def forget_judgements_from(self, stamp: int) -> None:
        """Discard the results from a stamp [ns] on, because odometry has changed there."""
        del self._outcomes[bisect_left(self._poses, (stamp,)) :]

    def drop_before(self, horizon: int) -> None:
        """Make the results of poses older than a stamp [ns] final and drop the poses."""
        old = bisect_left(self._poses, (horizon,))
        if old == 0:
            return
        self._judge_waiting(old)
        self._base = self._outcomes[old - 1][0]
        for pose, (_, verdict) in zip(self._poses[:old], self._outcomes[:old], strict=True):
            self._past[pose.source, verdict] += 1
        del self._poses[:old], self._outcomes[:old]

    def belief_at(self, stamp: int) -> Belief:
        """Return the filter state at a stamp [ns], after the poses up to it."""
        count = bisect_left(self._poses, (stamp + 1,))
        self._judge_waiting(count)
        return self._outcomes[count - 1][0] if count else self._base

    def counts(self) -> Counter[tuple[int, Verdict]]:
        """Return the number of poses by (source index, status)."""
        self._judge_waiting(len(self._poses))
        return self._past + Counter(
            (pose.source, verdict) for pose, (_, verdict) in zip(self._poses, self._outcomes, strict=True)
        )

    def _judge_waiting(self, count: int) -> None:
        """Process those of the first ``count`` poses that have no result yet."""
        for k in range(len(self._outcomes), count):
            pose = self._poses[k]
            before = self._outcomes[k - 1][0] if k else self._base
            self._outcomes.append(self._judge.judge(before, pose, self._trail.mark_at(pose.stamp)))
