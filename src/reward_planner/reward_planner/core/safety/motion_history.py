"""Pose and velocity of the base in a frame of its own: from odometry, or from the velocities it was given."""

import math
from collections import deque

from reward_planner.core.safety.stopping_motion import BaseDynamics, BaseMotion
from shirube_core.geometry import SE2
from shirube_core.motion import NoPoseReason, OdometryBuffer

_ODOMETRY_TIMEOUT = 0.3  # odometry that is older is not used [s]
_STEP_MAX = 0.02  # [s]
_HISTORY = 5.0  # [s]


class MotionHistory:
    """Motion of the base over the last seconds, to compare measurements and to predict its way.

    Without odometry the base is taken to follow the given velocities with its latency and accelerations.
    """

    def __init__(self, base: BaseDynamics) -> None:
        """Start at rest."""
        self._base = base
        self._odometry = OdometryBuffer(history=int(_HISTORY * 1e9))
        self._given: deque[tuple[float, float, float]] = deque([(-math.inf, 0.0, 0.0)])
        self._model = OdometryBuffer(history=int(_HISTORY * 1e9))
        self._time: float | None = None
        self._pose, self._forward, self._turn_rate = SE2(0.0, 0.0, 0.0), 0.0, 0.0
        self.uses_odometry = False

    def add_odometry(self, stamp: float, pose: SE2) -> None:
        """Add a pose of the odometry at a stamp [s]."""
        self._odometry.add(round(stamp * 1e9), pose)

    def give(self, now: float, forward: float, turn_rate: float) -> None:
        """Note the velocity that the base is given now [m/s, rad/s]."""
        self._given.append((now, forward, turn_rate))

    def advance(self, now: float) -> bool:
        """Predict the model up to now [s]; return whether the frame of the poses has changed."""
        if self._time is None:
            self._time = now
            self._model.add(round(now * 1e9), self._pose)
        steps = max(math.ceil((now - self._time) / _STEP_MAX), 0)
        for step in range(1, min(steps, 500) + 1):
            self._model_step(self._time + (now - self._time) * step / steps, (now - self._time) / steps)
        self._time = max(now, self._time)
        latest = self._odometry.latest
        is_fresh = latest is not None and abs(now - 1e-9 * latest) < _ODOMETRY_TIMEOUT
        changed, self.uses_odometry = is_fresh != self.uses_odometry, is_fresh
        return changed

    def pose_at(self, stamp: float) -> SE2 | None:
        """Return the pose at a stamp [s], None if it is unknown."""
        buffer = self._odometry if self.uses_odometry else self._model
        pose = buffer.pose_at(round(stamp * 1e9))
        return None if isinstance(pose, NoPoseReason) else pose

    def motion(self, now: float) -> BaseMotion:
        """Return the velocity now [s], and the one that the base was given last."""
        _, given_forward, given_turn_rate = self._given[-1]
        forward, turn_rate = self._forward, self._turn_rate
        if self.uses_odometry and self._odometry.latest is not None:
            forward, _, turn_rate = self._odometry.twist_at(min(round(now * 1e9), self._odometry.latest))
        return BaseMotion(forward, turn_rate, given_forward, given_turn_rate)

    def _model_step(self, time: float, dt: float) -> None:
        while len(self._given) > 1 and self._given[1][0] <= time - self._base.latency:
            self._given.popleft()
        _, aim_forward, aim_turn_rate = self._given[0]
        self._forward = _approach(self._forward, aim_forward, self._base.deceleration * dt)
        self._turn_rate = _approach(self._turn_rate, aim_turn_rate, self._base.angular_deceleration * dt)
        self._pose = self._pose @ SE2.exp(self._forward * dt, 0.0, self._turn_rate * dt)
        self._model.add(round(time * 1e9), self._pose)


def _approach(value: float, aim: float, change: float) -> float:
    return value + min(max(aim - value, -change), change)
