"""Localization status: whether the pose is known, and from which input."""

from __future__ import annotations

import math
from enum import Enum

from pose_arbiter.core.arbiter_settings import ArbiterSettings
from pose_arbiter.core.estimate import Estimate
from pose_arbiter.core.judge import Belief
from pose_arbiter.core.source_settings import SourceSettings


class Standing(Enum):
    """Status of localization; the value is the text of the diagnostics."""

    WAITING = 'no pose yet'
    FOLLOWED = 'pose known'
    ODOMETRY_ONLY = 'no source supports the pose, odometry only'
    LOST = 'pose lost'

    @property
    def has_pose(self) -> bool:
        """Whether there is a pose to publish."""
        return self in (Standing.FOLLOWED, Standing.ODOMETRY_ONLY)


def standing_of(
    belief: Belief, estimate: Estimate | None, sources: tuple[SourceSettings, ...], settings: ArbiterSettings
) -> Standing:
    """Return the localization status.

    Args:
        state: filter state.
        estimate: estimate predicted to the current time.
        sources: settings of each source, by source index.
        settings: standard deviations above which the pose is lost.
    """
    if estimate is None:
        return Standing.WAITING
    xx, xy, _, yy, _, tt = estimate.covariance
    longest = 0.5 * (xx + yy) + math.hypot(0.5 * (xx - yy), xy)  # the larger eigenvalue
    if longest > settings.lost_sigma_xy**2 or tt > settings.lost_sigma_yaw**2:
        return Standing.LOST
    stamp = estimate.mark.stamp
    if any(
        record.stands_by(stamp, round(source.timeout * 1e9))
        for record, source in zip(belief.records, sources, strict=True)
    ):
        return Standing.FOLLOWED
    return Standing.ODOMETRY_ONLY
