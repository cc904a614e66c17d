"""Robot model: motors, wheels and slip."""

from __future__ import annotations

import math

import numpy as np

from motor_bridge.emulator.emulator_settings import EmulatorSettings
from motor_bridge.emulator.wheel_pid import PWM_MAX
from shirube_core.geometry import SE2

_STOPPED_SPEED = 1e-3  # below this a wheel without voltage stops [rad/s]


class RobotModel:
    """A differential drive robot.

    Attributes:
        T_world_base: true pose of the robot.
        wheel_speeds: speeds of the left and the right wheel [rad/s].
        wheel_angles: angles of the left and the right wheel since the start [rad].
    """

    def __init__(self, settings: EmulatorSettings, rng: np.random.Generator, start: SE2) -> None:
        """Start at rest."""
        self._settings, self._rng = settings, rng
        self.T_world_base = start
        self.wheel_speeds = (0.0, 0.0)
        self.wheel_angles = (0.0, 0.0)

    def move(self, pwm: tuple[int, int], elapsed: float) -> None:
        """Simulate a short time step.

        Args:
            pwm: PWM of the left and the right motor, -255 to 255.
            elapsed: length of the step [s].
        """
        before = self.wheel_speeds
        left, right = (self._next_speed(s, p, elapsed) for s, p in zip(before, pwm, strict=True))
        self.wheel_speeds = left, right
        turned = 0.5 * elapsed * (before[0] + left), 0.5 * elapsed * (before[1] + right)
        self.wheel_angles = self.wheel_angles[0] + turned[0], self.wheel_angles[1] + turned[1]
        if turned != (0.0, 0.0):
            self._roll(*(self._settings.wheel_radius * angle for angle in turned))

    def read_counts(self) -> tuple[int, int]:
        """Return the noisy encoder counts since the start."""
        per_radian = self._settings.ticks_per_revolution / math.tau
        sigma = self._settings.encoder_noise
        noise = self._rng.normal(0.0, sigma, 2) if sigma else (0.0, 0.0)
        left, right = (round(per_radian * a + n) for a, n in zip(self.wheel_angles, noise, strict=True))
        return left, right

    def _next_speed(self, speed: float, pwm: int, elapsed: float) -> float:
        settings = self._settings
        target = 0.0 if abs(pwm) <= settings.motor_dead_band else settings.wheel_speed_max * pwm / PWM_MAX
        after = target + (speed - target) * math.exp(-elapsed / settings.motor_time_constant)
        return 0.0 if target == 0.0 and abs(after) < _STOPPED_SPEED else after

    def _roll(self, *distances: float) -> None:
        """Move the robot by the distances of its wheels [m], minus slip."""
        settings, sigma = self._settings, self._settings.slip_sigma
        left, right = (
            (1.0 - settings.slip) * distance
            + (sigma * math.sqrt(abs(distance)) * self._rng.normal() if sigma else 0.0)
            for distance in distances
        )
        forward, turn = 0.5 * (left + right), (right - left) / settings.wheel_separation
        chord = forward * (math.sin(0.5 * turn) / (0.5 * turn) if turn else 1.0)
        step = SE2(chord * math.cos(0.5 * turn), chord * math.sin(0.5 * turn), turn)
        self.T_world_base = self.T_world_base @ step
