"""The arbiter: poses and odometry in, in any order; one pose out."""

from __future__ import annotations

from collections import Counter
from collections.abc import Sequence

from pose_arbiter.core.arbiter_settings import ArbiterSettings
from pose_arbiter.core.covariance import Covariance, diagonal
from pose_arbiter.core.estimate import Estimate, moved_on
from pose_arbiter.core.history import History
from pose_arbiter.core.judge import Belief, Judge
from pose_arbiter.core.observation_check import refusal_of_covariance, refusal_of_pose
from pose_arbiter.core.odometry_trail import OdometryTrail
from pose_arbiter.core.sighting import Observation
from pose_arbiter.core.source_settings import SourceSettings
from pose_arbiter.core.verdict import Refusal, Verdict
from shirube_geometry import PlanarPose

PERSON = -1
"""The source of poses that a person tells."""
_AHEAD_MAX = 100_000_000  # clocks that are set alike differ by no more [ns]


class Arbiter:
    """One pose of all sources and odometry.

    What is believed at a stamp depends only on the messages with stamps up to it (and on the odometry just after it),
    not on the order in which they came, as long as they came within the history.
    """

    def __init__(self, sources: Sequence[SourceSettings], settings: ArbiterSettings) -> None:
        """Begin without a pose.

        Args:
            sources: in the order of their numbers.
            settings: of the method.
        """
        self._settings, self._sources = settings, tuple(sources)
        self._offsets = [PlanarPose(*source.offset) for source in sources]
        self._sigmas = [diagonal(source.sigma_xy**2, source.sigma_yaw**2) for source in sources]
        self._judge = Judge(sources, settings)
        self._length = round(settings.history_seconds * 1e9)
        self.reset()

    def reset(self) -> None:
        """Forget everything."""
        self._trail = OdometryTrail(self._settings)
        self._history = History(self._judge, self._trail)
        self._newest: int | None = None

    def add_odometry(self, stamp: int, T_odom_base: PlanarPose, now: int) -> Refusal | None:
        """Take odometry.

        Args:
            stamp: [ns].
            T_odom_base: the pose.
            now: the time [ns].

        Returns:
            why it was refused, else None.
        """
        refusal = refusal_of_pose(T_odom_base) or self._refusal_of_stamp(stamp, now)
        if refusal is not None:
            return refusal
        changed = self._trail.add(stamp, T_odom_base)
        if changed is None:
            return Refusal.DUPLICATE
        self._history.forget_judgements_from(changed)
        self._advance(stamp)
        return None

    def add_pose(
        self, source: int, stamp: int, pose: PlanarPose, noise: Covariance | None, now: int
    ) -> Refusal | None:
        """Take a pose of a source, or of a `PERSON`.

        Args:
            source: its number.
            stamp: [ns].
            pose: in the map, of the frame that the source looks after.
            noise: its covariance; None takes the sigmas of the source.
            now: the time [ns].

        Returns:
            why it was refused, else None; what is believed of it is seen later.
        """
        if noise is None:
            noise = self._sigmas[source]
        refusal = refusal_of_pose(pose) or refusal_of_covariance(noise) or self._refusal_of_stamp(stamp, now)
        if refusal is not None:
            return refusal
        if self._history.has(stamp, source):
            return Refusal.DUPLICATE
        if source != PERSON:
            pose = pose @ self._offsets[source]
        self._history.add(Observation(stamp, source, pose.x, pose.y, pose.yaw, noise))
        self._advance(stamp)
        return None

    def belief_at(self, stamp: int) -> Belief:
        """Return what is believed at a stamp [ns] that is within the history or newer."""
        return self._history.belief_at(stamp)

    def estimate_at(self, stamp: int) -> Estimate | None:
        """Return the pose at a stamp [ns] that is within the history or newer, None before the start."""
        estimate = self._history.belief_at(stamp).estimate
        if estimate is None or estimate.mark.stamp >= stamp:
            return estimate
        return moved_on(estimate, self._trail.mark_at(stamp), self._settings)

    def T_map_odom(self, estimate: Estimate) -> PlanarPose | None:  # noqa: N802
        """Return the pose of the odometry's frame in the map at an estimate's stamp, None without odometry."""
        T_odom_base = self._trail.odometry_at(estimate.mark.stamp)
        if T_odom_base is None:
            return None
        return PlanarPose(estimate.x, estimate.y, estimate.yaw) @ T_odom_base.inverse()

    def counts(self) -> Counter[tuple[int, Verdict]]:
        """Return how many poses got which judgement, by the number of their source."""
        return self._history.counts()

    @property
    def latest_odometry(self) -> int | None:
        """Stamp of the newest odometry [ns]."""
        return self._trail.latest

    def _refusal_of_stamp(self, stamp: int, now: int) -> Refusal | None:
        if stamp <= 0:
            return Refusal.NO_STAMP
        if stamp > now + _AHEAD_MAX:
            return Refusal.FUTURE
        newest = now if self._newest is None else max(now, self._newest)
        return Refusal.TOO_OLD if stamp < newest - self._length else None

    def _advance(self, stamp: int) -> None:
        if self._newest is not None and stamp <= self._newest:
            return
        self._newest = stamp
        self._history.drop_before(stamp - self._length)
        self._trail.drop_before(stamp - self._length)
