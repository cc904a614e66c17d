"""The poses of the last seconds in the order of their stamps, and what was believed after each of them."""

from __future__ import annotations

from bisect import bisect_left
from collections import Counter

from pose_arbiter.core.judge import Belief, Judge
from pose_arbiter.core.odometry_trail import OdometryTrail
from pose_arbiter.core.sighting import Observation
from pose_arbiter.core.verdict import Verdict


class History:
    """Rewinds to a late pose and judges again from there on; works only when it is asked for what is believed."""

    def __init__(self, judge: Judge, trail: OdometryTrail) -> None:
        """Begin without poses.

        Args:
            judge: the rules.
            trail: odometry, kept up to date by the owner, who tells what changed in it.
        """
        self._judge, self._trail = judge, trail
        self._base = judge.beginning()  # what was believed before the first of the poses
        self._poses: list[Observation] = []
        self._outcomes: list[tuple[Belief, Verdict]] = []  # of the poses that are judged
        self._past: Counter[tuple[int, Verdict]] = Counter()  # judgements that are final

    def has(self, stamp: int, source: int) -> bool:
        """Return whether a pose of that stamp [ns] and source is here."""
        place = bisect_left(self._poses, (stamp, source))
        return place < len(self._poses) and self._poses[place][:2] == (stamp, source)

    def add(self, pose: Observation) -> None:
        """Take a pose to its place; those after it are to be judged again."""
        place = bisect_left(self._poses, pose)
        self._poses.insert(place, pose)
        del self._outcomes[place:]

    def forget_judgements_from(self, stamp: int) -> None:
        """Have poses judged again whose stamp [ns] is not older, as odometry there has changed."""
        del self._outcomes[bisect_left(self._poses, (stamp,)) :]

    def drop_before(self, horizon: int) -> None:
        """Make the judgements of poses older than a stamp [ns] final."""
        old = bisect_left(self._poses, (horizon,))
        if old == 0:
            return
        self._judge_waiting(old)
        self._base = self._outcomes[old - 1][0]
        for pose, (_, verdict) in zip(self._poses[:old], self._outcomes[:old], strict=True):
            self._past[pose.source, verdict] += 1
        del self._poses[:old], self._outcomes[:old]

    def belief_at(self, stamp: int) -> Belief:
        """Return what is believed at a stamp [ns], after the poses up to it."""
        count = bisect_left(self._poses, (stamp + 1,))
        self._judge_waiting(count)
        return self._outcomes[count - 1][0] if count else self._base

    def counts(self) -> Counter[tuple[int, Verdict]]:
        """Return how many poses got which judgement, by the number of their source."""
        self._judge_waiting(len(self._poses))
        return self._past + Counter(
            (pose.source, verdict) for pose, (_, verdict) in zip(self._poses, self._outcomes, strict=True)
        )

    def _judge_waiting(self, count: int) -> None:
        """Judge the first ``count`` poses, as far as that is not done."""
        for k in range(len(self._outcomes), count):
            pose = self._poses[k]
            before = self._outcomes[k - 1][0] if k else self._base
            self._outcomes.append(self._judge.judge(before, pose, self._trail.mark_at(pose.stamp)))
