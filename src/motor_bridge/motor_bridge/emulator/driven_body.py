"""Motors, wheels and the floor: where the robot really goes."""

from __future__ import annotations

import math

import numpy as np

from motor_bridge.emulator.emulator_settings import EmulatorSettings
from motor_bridge.emulator.wheel_pid import PWM_MAX
from shirube_geometry import PlanarPose

_STILL = 1e-3  # a wheel without voltage that is slower stands [rad/s]


class DrivenBody:
    """A robot on two driven wheels.

    Attributes:
        T_world_base: its true pose.
        wheel_speeds: of the left and the right wheel [rad/s].
        wheel_angles: turned so far [rad].
    """

    def __init__(self, settings: EmulatorSettings, rng: np.random.Generator, start: PlanarPose) -> None:
        """Put the robot at rest."""
        self._settings, self._rng = settings, rng
        self.T_world_base = start
        self.wheel_speeds = (0.0, 0.0)
        self.wheel_angles = (0.0, 0.0)

    def move(self, pwm: tuple[int, int], elapsed: float) -> None:
        """Drive for a short time.

        Args:
            pwm: of the motors, left and right, -255 to 255.
            elapsed: [s].
        """
        before = self.wheel_speeds
        left, right = (self._next_speed(s, p, elapsed) for s, p in zip(before, pwm, strict=True))
        self.wheel_speeds = left, right
        turned = 0.5 * elapsed * (before[0] + left), 0.5 * elapsed * (before[1] + right)
        self.wheel_angles = self.wheel_angles[0] + turned[0], self.wheel_angles[1] + turned[1]
        if turned != (0.0, 0.0):
            self._roll(*(self._settings.wheel_radius * angle for angle in turned))

    def read_counts(self) -> tuple[int, int]:
        """Return what the encoders show since the start, with their noise."""
        per_radian = self._settings.ticks_per_revolution / math.tau
        noise = self._rng.normal(0.0, self._settings.encoder_noise, 2)
        left, right = (round(per_radian * a + n) for a, n in zip(self.wheel_angles, noise, strict=True))
        return left, right

    def _next_speed(self, speed: float, pwm: int, elapsed: float) -> float:
        settings = self._settings
        aim = 0.0 if abs(pwm) <= settings.motor_dead_band else settings.wheel_speed_max * pwm / PWM_MAX
        after = aim + (speed - aim) * math.exp(-elapsed / settings.motor_time_constant)
        return 0.0 if aim == 0.0 and abs(after) < _STILL else after

    def _roll(self, *ways: float) -> None:
        """Move the body by the ways of its wheels [m], less what they slip."""
        settings = self._settings
        left, right = (
            (1.0 - settings.slip) * way + settings.slip_sigma * math.sqrt(abs(way)) * self._rng.normal()
            for way in ways
        )
        forward, turn = 0.5 * (left + right), (right - left) / settings.wheel_separation
        chord = forward * float(np.sinc(0.5 * turn / np.pi))
        step = PlanarPose(chord * math.cos(0.5 * turn), chord * math.sin(0.5 * turn), turn)
        self.T_world_base = self.T_world_base @ step
