"""Prediction of the next pose, with its tolerances, from odometry or from the last velocity."""

from __future__ import annotations

import math
from collections import deque

from floor_localizer.core.fix import PosePrior
from floor_localizer.core.settings import TrackerSettings
from shirube_core.geometry import SE2
from shirube_core.motion import NoPoseReason, OdometryBuffer


class PosePredictor:
    """Buffers odometry and the last two poses, and predicts the next pose."""

    def __init__(self, settings: TrackerSettings) -> None:
        """Start with empty buffers.

        Args:
            settings: tolerances of the prediction.
        """
        self._settings = settings
        self._odometry = OdometryBuffer()
        self._poses: deque[tuple[float, SE2]] = deque(maxlen=2)

    def add_odometry(self, stamp: float, T_odom_base: SE2) -> None:
        """Add an odometry pose, in any order; a stamp that is there already is ignored."""
        self._odometry.add(round(1e9 * stamp), T_odom_base)

    def add_pose(self, stamp: float, T_map_base: SE2) -> None:
        """Add a pose that was found."""
        self._poses.append((stamp, T_map_base))

    def clear_poses(self) -> None:
        """Clear the poses, but not the odometry."""
        self._poses.clear()

    def relative_motion(self, earlier: float, later: float) -> SE2 | None:
        """Return the pose at ``later`` in the base frame at ``earlier`` from odometry, None if unknown."""
        motion = self._odometry.motion(round(1e9 * earlier), round(1e9 * later))
        return None if isinstance(motion, NoPoseReason) else motion

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
            step = SE2.exp(*(dt / interval * v for v in (first.inverse() @ last).log()))
        squared_time = dt * (dt + interval) if interval > 0.0 else dt * max(dt, 0.3)
        return PosePrior(
            last @ step,
            settings.still_radius + settings.acceleration_max * squared_time,
            min(settings.still_turn + settings.turn_acceleration_max * squared_time, math.pi),
        )
