"""Prediction of the next pose, with its tolerances, from odometry or from the last velocity."""

from __future__ import annotations

import bisect
import math
from collections import deque

from floor_localizer.core.fix import PosePrior
from floor_localizer.core.settings import TrackerSettings
from shirube_core.geometry import SE2

_BUFFER_SIZE = 4000
# Odometry with a larger time difference from an image is not used [s].
_STALE_SECONDS = 0.25


class PosePredictor:
    """Buffers odometry and the last two poses, and predicts the next pose."""

    def __init__(self, settings: TrackerSettings) -> None:
        """Start with empty buffers.

        Args:
            settings: tolerances of the prediction.
        """
        self._settings = settings
        self._odometry: deque[tuple[float, SE2]] = deque(maxlen=_BUFFER_SIZE)
        self._poses: deque[tuple[float, SE2]] = deque(maxlen=2)

    def add_odometry(self, stamp: float, T_odom_base: SE2) -> None:
        """Add an odometry pose; ignored unless newer than the last one."""
        if not self._odometry or stamp > self._odometry[-1][0]:
            self._odometry.append((stamp, T_odom_base))

    def add_pose(self, stamp: float, T_map_base: SE2) -> None:
        """Add a pose that was found."""
        self._poses.append((stamp, T_map_base))

    def clear_poses(self) -> None:
        """Clear the poses, but not the odometry."""
        self._poses.clear()

    def interpolate_odometry(self, stamp: float) -> SE2 | None:
        """Interpolate ``T_odom_base`` at a time; None without odometry close in time.

        An image is often newer than the last odometry: then the pose is extrapolated from the last two messages.
        """
        if not self._odometry:
            return None
        k = bisect.bisect_left(self._odometry, stamp, key=lambda entry: entry[0])
        before, after = self._odometry[max(k - 1, 0)], self._odometry[min(k, len(self._odometry) - 1)]
        if min(abs(stamp - before[0]), abs(stamp - after[0])) > _STALE_SECONDS:
            return None
        if (
            stamp > after[0]
            and len(self._odometry) > 1
            and after[0] - self._odometry[-2][0] <= _STALE_SECONDS
        ):
            before = self._odometry[-2]
            return after[1] @ _scale_step(before, after, (stamp - after[0]) / (after[0] - before[0]))
        if not before[0] < stamp < after[0]:
            return min((before, after), key=lambda entry: abs(entry[0] - stamp))[1]
        return before[1] @ _scale_step(before, after, (stamp - before[0]) / (after[0] - before[0]))

    def relative_motion(self, earlier: float, later: float) -> SE2 | None:
        """Return the pose at ``later`` in the base frame at ``earlier`` from odometry, None if unknown."""
        start, end = self.interpolate_odometry(earlier), self.interpolate_odometry(later)
        return None if start is None or end is None else start.inverse() @ end

    def predict(self, stamp: float) -> PosePrior | None:
        """Predict the pose at a time; None if unknown or too uncertain to be useful."""
        if not self._poses or stamp < self._poses[-1][0]:
            return None
        last_stamp, last = self._poses[-1]
        step = self.relative_motion(last_stamp, stamp)
        prior = (
            self._predict_from_velocity(stamp) if step is None else self._predict_from_odometry(last, step)
        )
        return prior if prior.radius <= self._settings.prior_radius_max else None

    def _predict_from_odometry(self, last: SE2, step: SE2) -> PosePrior:
        settings = self._settings
        distance = math.hypot(step.x, step.y)
        error = settings.odometry_error
        return PosePrior(
            last @ step,
            settings.still_radius + error * distance,
            min(settings.still_turn + error * (distance + abs(step.yaw)), math.pi),
        )

    def _predict_from_velocity(self, stamp: float) -> PosePrior:
        """Predict with the velocity between the last two poses; the tolerances cover the maximum acceleration."""
        settings = self._settings
        last_stamp, last = self._poses[-1]
        dt = stamp - last_stamp
        first_stamp, first = self._poses[0]
        interval = last_stamp - first_stamp
        step = SE2(0.0, 0.0, 0.0)
        if interval > 0.0:
            last_step = first.inverse() @ last
            fraction = dt / interval
            step = SE2(fraction * last_step.x, fraction * last_step.y, fraction * last_step.yaw)
        squared_time = dt * (dt + interval) if interval > 0.0 else dt * max(dt, 0.3)
        return PosePrior(
            last @ step,
            settings.still_radius + settings.acceleration_max * squared_time,
            min(settings.still_turn + settings.turn_acceleration_max * squared_time, math.pi),
        )


def _scale_step(before: tuple[float, SE2], after: tuple[float, SE2], fraction: float) -> SE2:
    step = before[1].inverse() @ after[1]
    return SE2(fraction * step.x, fraction * step.y, fraction * step.yaw)
