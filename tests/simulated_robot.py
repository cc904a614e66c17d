"""A simulated robot that follows velocity commands within its acceleration limits."""

import math
from bisect import bisect_right
from dataclasses import dataclass

from scene_simulator.errors import SceneError
from scene_simulator.robot.leg_drive import arc_motion
from shirube_core.geometry import SE2

_STEP = 0.005
"""Longest time in which the speeds are held [s]."""


@dataclass(frozen=True)
class MotorLimits:
    """Maximum linear [m/s^2] and angular acceleration [rad/s^2]."""

    acceleration: float = 0.5
    angular_acceleration: float = 3.0


class SimulatedRobot:
    """True motion of a robot from time 0 to the end of the last command."""

    def __init__(self, start: SE2, limits: MotorLimits | None = None) -> None:
        """Start with the robot stationary at ``T_map_base``."""
        self._limits = limits or MotorLimits()
        self._times, self._poses = [0.0], [start]
        self._forward, self._yaw_rate = 0.0, 0.0
        self._speeds: list[tuple[float, float]] = []

    @property
    def time(self) -> float:
        """Time up to which the motion has been simulated [s]."""
        return self._times[-1]

    def drive(self, forward: float, yaw_rate: float, until: float) -> None:
        """Follow a speed [m/s] and a yaw rate [rad/s] up to a time [s], as fast as the motors allow."""
        assert all(map(math.isfinite, (forward, yaw_rate, until)))
        assert until >= self.time
        start, count = self.time, math.ceil((until - self.time) / _STEP)
        for step in range(count):
            after = start + (until - start) * (step + 1) / count
            elapsed = after - self.time
            self._forward = _step_towards(forward, self._forward, self._limits.acceleration * elapsed)
            self._yaw_rate = _step_towards(yaw_rate, self._yaw_rate, self._limits.angular_acceleration * elapsed)
            self._poses.append(self._poses[-1] @ arc_motion(self._forward * elapsed, self._yaw_rate * elapsed))
            self._speeds.append((self._forward, self._yaw_rate))
            self._times.append(after)

    def pose_at(self, time: float) -> SE2:
        """Return ``T_map_base`` at a time [s] until which it has been driven; before 0 it is at its start."""
        if time > self.time + 1e-9:
            raise SceneError(f'the robot has been driven until {self.time} s, not until {time} s')
        step = min(bisect_right(self._times, time) - 1, len(self._speeds) - 1)
        if step < 0:
            return self._poses[0]
        forward, yaw_rate = self._speeds[step]
        since = time - self._times[step]
        return self._poses[step] @ arc_motion(forward * since, yaw_rate * since)


def _step_towards(goal: float, value: float, max_step: float) -> float:
    return value + min(max(goal - value, -max_step), max_step)
