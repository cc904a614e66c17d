"""Wheel speed commands from cmd_vel: timeout, emergency stop, velocity limits and rounding to ticks."""

import math

from motor_bridge.core.diff_drive_kinematics import TICKS_MAX, DiffDriveKinematics, Velocity
from motor_bridge.core.drive_settings import DriveSettings
from motor_bridge.core.velocity_limiter import VelocityLimiter

_STOPPED = Velocity()


class BaseDrive:
    """Converts velocity commands to wheel speeds.

    Attributes:
        is_stopped: whether the emergency stop is active.
    """

    def __init__(self, kinematics: DiffDriveKinematics, settings: DriveSettings, period: float) -> None:
        """Start at rest; ``period`` is that of the calls of `next_ticks` [s]."""
        self._kinematics, self._timeout = kinematics, settings.cmd_vel_timeout
        self._limiter = VelocityLimiter(settings)
        self._accumulators = [TickAccumulator(kinematics.frame, period) for _ in range(2)]
        self.is_stopped = False
        self._target, self._target_time = _STOPPED, -math.inf
        self._last_time: float | None = None

    def apply_settings(self, settings: DriveSettings) -> None:
        """Use another timeout and other velocity limits."""
        self._timeout = settings.cmd_vel_timeout
        self._limiter.apply_settings(settings)

    @property
    def velocity(self) -> Velocity:
        """Velocity that is commanded now."""
        return self._limiter.velocity

    def set_target(self, velocity: Velocity, now: float) -> None:
        """Set the target velocity; it is ignored during an emergency stop."""
        if not self.is_stopped:
            self._target, self._target_time = velocity, now

    def set_emergency_stop(self, *, is_on: bool) -> None:
        """Stop at once, or allow later target velocities again."""
        self.is_stopped = is_on
        if is_on:
            self.halt()

    def halt(self) -> None:
        """Stop at once and drop the target velocity."""
        self._target, self._target_time = _STOPPED, -math.inf
        self._limiter.halt()
        for accumulator in self._accumulators:
            accumulator.clear()

    def is_timed_out(self, now: float) -> bool:
        """Return whether the target velocity timed out or was never set."""
        return not 0.0 <= now - self._target_time <= self._timeout

    def next_ticks(self, now: float) -> tuple[int, int]:
        """Return the speeds of the left and the right wheel [ticks per frame].

        A clock that jumps back counts as no elapsed time.
        """
        elapsed = 0.0 if self._last_time is None else max(0.0, now - self._last_time)
        self._last_time = now
        target = _STOPPED if self.is_timed_out(now) else self._target
        ticks = clamp_ticks(*self._kinematics.to_wheel_ticks(self._limiter.step_toward(target, elapsed)))
        left, right = (r.next_ticks(t, elapsed) for r, t in zip(self._accumulators, ticks, strict=True))
        return left, right


def clamp_ticks(left: float, right: float) -> tuple[float, float]:
    """Scale both speeds by one factor so that they fit into 16 bits: the curvature is kept."""
    factor = min(1.0, TICKS_MAX / max(abs(left), abs(right), 1.0))
    return factor * left, factor * right


class TickAccumulator:
    """Rounds a speed up or down so that the mean is exact.

    The accumulated error is the target distance minus the commanded distance [ticks]. Of the two neighbouring integers
    the one is chosen that gives the smaller error after one period, so that late calls are compensated later.
    """

    def __init__(self, frame: float, period: float) -> None:
        """Start with no error, for a frame of the firmware [s] and an expected time between two calls [s]."""
        self._frame, self._frames = frame, period / frame
        self.clear()

    def clear(self) -> None:
        """Reset the error, with the wheel at rest."""
        self._error = self._target = 0.0
        self._commanded = 0

    def next_ticks(self, target: float, elapsed: float) -> int:
        """Return the speed to command now, for a target [ticks per frame] and the time since the last call [s]."""
        self._error += (self._target - self._commanded) * elapsed / self._frame
        if target == 0.0 or target * self._target < 0.0:
            self._error = 0.0  # a stopped wheel must not turn, and the error is not carried over a reversal
        below = math.floor(target)
        choices = (below, below + 1) if target != below else (below,)
        self._commanded = min(choices, key=lambda commanded: abs(self._error + (target - commanded) * self._frames))
        self._target = target
        return self._commanded
