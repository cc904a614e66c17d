"""Simulated differential-drive robot with delayed velocities and noisy poses."""

from collections import deque

import numpy as np

from shirube_core.geometry import SE2
from vlc_beacon.core.command_executor import CommandExecutor, Velocity

STEP = 1.0 / 60.0
DELAY_STEPS = 4


class DrivenRobot:
    """Moves under an executor, step by step.

    Attributes:
        pose: the true one.
        track: all true poses so far.
        velocities: what the executor gave.
    """

    def __init__(self, executor: CommandExecutor, pose: SE2, seed: int = 0, noise: float = 0.003) -> None:
        self.executor, self.pose, self.stamp = executor, pose, 0.0
        self.track: list[SE2] = [pose]
        self.velocities: list[Velocity | None] = []
        self._rng, self._noise = np.random.default_rng(seed), noise
        self._coming = deque([Velocity()] * DELAY_STEPS)

    def drive(self, seconds: float, sees: bool = True) -> None:
        """Move on for a while, with or without poses."""
        for _ in range(round(seconds / STEP)):
            if sees:
                pose = np.array([self.pose.x, self.pose.y, self.pose.yaw])
                self.executor.update_pose(self.stamp, SE2(*self._rng.normal(pose, self._noise)))
            velocity = self.executor.velocity(self.stamp)
            self.velocities.append(velocity)
            self._coming.append(velocity or Velocity())
            self._move(self._coming.popleft())

    def _move(self, velocity: Velocity) -> None:
        # The wheels turn 3 % less than they are told.
        arc = SE2.exp(0.97 * velocity.forward * STEP, 0.0, 0.97 * velocity.turn_rate * STEP)
        moved = self.pose @ arc
        self.pose = SE2(moved.x, moved.y, self.pose.yaw + arc.yaw)
        self.track.append(self.pose)
        self.stamp += STEP
