"""Localization status: whether the pose is known, and from which input."""

import math
from enum import Enum

from pose_arbiter.core.kalman_filter import Estimate
from pose_arbiter.core.outlier_rejection import FilterState
from pose_arbiter.core.settings import ArbiterSettings, SourceSettings


class LocalizationStatus(Enum):
    """Status of localization; the value is the text of the diagnostics."""

    WAITING = 'no pose yet'
    TRACKING = 'pose known'
    ODOMETRY_ONLY = 'no source supports the pose, odometry only'
    LOST = 'pose lost'

    @property
    def has_pose(self) -> bool:
        """Whether there is a pose to publish."""
        return self in (LocalizationStatus.TRACKING, LocalizationStatus.ODOMETRY_ONLY)


def localization_status(
    state: FilterState, estimate: Estimate | None, sources: tuple[SourceSettings, ...], settings: ArbiterSettings
) -> LocalizationStatus:
    """Return the localization status.

    Args:
        state: filter state.
        estimate: estimate predicted to the current time.
        sources: settings of each source, by source index.
        settings: standard deviations above which the pose is lost.
    """
    if estimate is None:
        return LocalizationStatus.WAITING
    xx, xy, _, yy, _, tt = estimate.covariance
    max_variance = 0.5 * (xx + yy) + math.hypot(0.5 * (xx - yy), xy)  # the larger eigenvalue
    if max_variance > settings.lost_sigma_xy**2 or tt > settings.lost_sigma_yaw**2:
        return LocalizationStatus.LOST
    stamp = estimate.odometry.stamp
    if any(
        source_state.is_supporting(stamp, round(source.timeout * 1e9))
        for source_state, source in zip(state.source_states, sources, strict=True)
    ):
        return LocalizationStatus.TRACKING
    return LocalizationStatus.ODOMETRY_ONLY
