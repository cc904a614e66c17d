"""Wheel speed commands from cmd_vel: timeout, emergency stop, velocity limits and rounding to ticks."""

from __future__ import annotations

import math

from motor_bridge.core.drive_settings import DriveSettings
from motor_bridge.core.tick_rounding import TickRounding, clamp_ticks
from motor_bridge.core.velocity import Velocity
from motor_bridge.core.velocity_limiter import VelocityLimiter
from motor_bridge.core.wheel_base import WheelBase

_REST = Velocity()


class BaseDrive:
    """Converts velocity commands to wheel speeds.

    Attributes:
        is_stopped: whether the emergency stop is active.
    """

    def __init__(self, base: WheelBase, settings: DriveSettings, period: float) -> None:
        """Start at rest.

        Args:
            kinematics: kinematics of the wheels.
            settings: velocity limits and timeout.
            period: period of the calls of `next_ticks` [s].
        """
        self._base, self._timeout = base, settings.cmd_vel_timeout
        self._limiter = VelocityLimiter(settings)
        self._roundings = TickRounding(base.frame, period), TickRounding(base.frame, period)
        self.is_stopped = False
        self._wanted, self._wanted_at = _REST, -math.inf
        self._latest: float | None = None

    @property
    def velocity(self) -> Velocity:
        """Velocity that is commanded now."""
        return self._limiter.velocity

    def want(self, velocity: Velocity, now: float) -> None:
        """Set the target velocity; it is ignored during an emergency stop."""
        if not self.is_stopped:
            self._wanted, self._wanted_at = velocity, now

    def emergency(self, *, is_on: bool) -> None:
        """Stop at once, or allow later target velocities again."""
        self.is_stopped = is_on
        if is_on:
            self.halt()

    def halt(self) -> None:
        """Stop at once and drop the target velocity."""
        self._wanted, self._wanted_at = _REST, -math.inf
        self._limiter.halt()
        for rounding in self._roundings:
            rounding.clear()

    def is_silent(self, now: float) -> bool:
        """Return whether the target velocity timed out or was never set."""
        return not 0.0 <= now - self._wanted_at <= self._timeout

    def next_ticks(self, now: float) -> tuple[int, int]:
        """Return the speeds of the left and the right wheel [ticks per frame].

        A clock that jumps back counts as no elapsed time.
        """
        elapsed = 0.0 if self._latest is None else max(0.0, now - self._latest)
        self._latest = now
        wanted = _REST if self.is_silent(now) else self._wanted
        ticks = clamp_ticks(*self._base.ticks_of(self._limiter.toward(wanted, elapsed)))
        left, right = (r.round(t, elapsed) for r, t in zip(self._roundings, ticks, strict=True))
        return left, right
