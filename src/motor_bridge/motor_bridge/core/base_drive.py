"""What the wheels are told: the wanted velocity, led through timeout, e-stop, limits and rounding."""

from __future__ import annotations

import math

from motor_bridge.core.drive_settings import DriveSettings
from motor_bridge.core.tick_rounding import TickRounding, clamp_ticks
from motor_bridge.core.velocity import Velocity
from motor_bridge.core.velocity_limiter import VelocityLimiter
from motor_bridge.core.wheel_base import WheelBase

_REST = Velocity()


class BaseDrive:
    """Velocities in, speeds of wheels out.

    Attributes:
        is_stopped: whether the e-stop holds the robot.
    """

    def __init__(self, base: WheelBase, settings: DriveSettings, period: float) -> None:
        """Stand.

        Args:
            base: the wheels.
            settings: the limits.
            period: between two calls of `next_ticks` [s].
        """
        self._base, self._timeout = base, settings.cmd_vel_timeout
        self._limiter = VelocityLimiter(settings)
        self._roundings = TickRounding(base.frame, period), TickRounding(base.frame, period)
        self.is_stopped = False
        self._wanted, self._wanted_at = _REST, -math.inf
        self._latest: float | None = None

    @property
    def velocity(self) -> Velocity:
        """What the wheels are told now."""
        return self._limiter.velocity

    def want(self, velocity: Velocity, now: float) -> None:
        """Take a velocity that somebody wants; while the e-stop holds, it is dropped."""
        if not self.is_stopped:
            self._wanted, self._wanted_at = velocity, now

    def emergency(self, *, is_on: bool) -> None:
        """Stop at once, or let velocities that come later be followed again."""
        self.is_stopped = is_on
        if is_on:
            self.halt()

    def halt(self) -> None:
        """Stand at once and want nothing."""
        self._wanted, self._wanted_at = _REST, -math.inf
        self._limiter.halt()
        for rounding in self._roundings:
            rounding.clear()

    def is_silent(self, now: float) -> bool:
        """Return whether nobody wants anything any more, or ever did."""
        return not 0.0 <= now - self._wanted_at <= self._timeout

    def next_ticks(self, now: float) -> tuple[int, int]:
        """Return the speeds for the left and the right wheel from now on [ticks a frame].

        A clock that goes back is no time that passes.
        """
        elapsed = 0.0 if self._latest is None else max(0.0, now - self._latest)
        self._latest = now
        wanted = _REST if self.is_silent(now) else self._wanted
        ticks = clamp_ticks(*self._base.ticks_of(self._limiter.toward(wanted, elapsed)))
        left, right = (r.round(t, elapsed) for r, t in zip(self._roundings, ticks, strict=True))
        return left, right
