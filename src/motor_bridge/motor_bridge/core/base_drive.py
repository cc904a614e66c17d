"""Wheel speed commands from cmd_vel: timeout, emergency stop, velocity limits and rounding to ticks."""

import math

from motor_bridge.core.diff_drive_kinematics import TICKS_MAX, DiffDriveKinematics, DriveSettings, Velocity

STEP = 0.005
"""Time step of the limiter [s]."""
_ELAPSED_MAX = 0.2  # upper bound of the time between two calls [s]
_ROUNDING = 1e-12  # rounding error of floats [s]
_Components = tuple[float, float]


class VelocityLimiter:
    """Velocity with limited speed, acceleration and jerk."""

    def __init__(self, settings: DriveSettings) -> None:
        self._unit = 1.0, 1.0
        self._u: _Components = (0.0, 0.0)
        self._acceleration: _Components = (0.0, 0.0)
        self._unused_time = 0.0
        self.apply_settings(settings)

    def apply_settings(self, settings: DriveSettings) -> None:
        """Use other limits from the present velocity on, which brakes to a lower maximum speed."""
        before, u, acceleration = self._unit, self._u, self._acceleration
        self._unit = settings.max_linear_acceleration, settings.max_angular_acceleration
        self._fastest = (settings.max_linear_velocity / self._unit[0], settings.max_angular_velocity / self._unit[1])
        self._jerk = settings.max_linear_jerk / settings.max_linear_acceleration
        scale = before[0] / self._unit[0], before[1] / self._unit[1]
        self._u = u[0] * scale[0], u[1] * scale[1]
        self._acceleration = acceleration[0] * scale[0], acceleration[1] * scale[1]

    @property
    def velocity(self) -> Velocity:
        """Latest velocity."""
        return Velocity(self._u[0] * self._unit[0], self._u[1] * self._unit[1])

    def halt(self) -> None:
        """Stop at once, without limits."""
        self._u = self._acceleration = (0.0, 0.0)
        self._unused_time = 0.0

    def step_toward(self, target_velocity: Velocity, elapsed: float) -> Velocity:
        """Return the next velocity towards a finite target, which is scaled down by one factor if it is too fast.

        The remainder of a step of the time since the last call [s] is kept for the next call.
        """
        target = self._clamp_speed(target_velocity.forward / self._unit[0], target_velocity.turn_rate / self._unit[1])
        self._unused_time += min(max(elapsed, 0.0), _ELAPSED_MAX)
        count = math.floor(self._unused_time / STEP + 1e-9)
        self._unused_time = max(0.0, self._unused_time - count * STEP)
        for _ in range(count):
            if self._u == target and self._acceleration == (0.0, 0.0):
                break
            self._step(target)
        return self.velocity

    def _clamp_speed(self, *target: float) -> _Components:
        factor = max(1.0, abs(target[0]) / self._fastest[0], abs(target[1]) / self._fastest[1])
        return target[0] / factor, target[1] / factor

    def _step(self, target: _Components) -> None:
        error = target[0] - self._u[0], target[1] - self._u[1]
        distance = max(abs(error[0]), abs(error[1]))
        per_distance = min(1.0, self._stopping_acceleration(distance)) / distance if distance else 0.0
        change = [per_distance * m - a for m, a in zip(error, self._acceleration, strict=True)]
        change_max = self._jerk * STEP
        scale = min(1.0, change_max / max(abs(change[0]), abs(change[1]), 1e-300))
        left, right = (self._limit_component(axis, error[axis], scale * change[axis]) for axis in (0, 1))
        self._acceleration = left, right
        self._u = self._u[0] + STEP * left, self._u[1] + STEP * right
        if max(abs(target[0] - self._u[0]), abs(target[1] - self._u[1])) < _ROUNDING:
            self._u = target

    def _limit_component(self, axis: int, error: float, change: float) -> float:
        """Return the next acceleration of one component.

        After a change of the target, one component may have to brake earlier than both together: before its target and
        before its maximum speed.
        """
        before, speed, fastest = self._acceleration[axis], self._u[axis], self._fastest[axis]
        most = min(1.0, self._stopping_acceleration(max(0.0, fastest - speed)))
        least = -min(1.0, self._stopping_acceleration(max(0.0, fastest + speed)))
        if error >= 0.0:
            most = min(most, self._stopping_acceleration(error))
        if error <= 0.0:
            least = max(least, -self._stopping_acceleration(-error))
        change_max = self._jerk * STEP
        target_velocity = max(least, min(before + change, most))
        return max(before - change_max, min(target_velocity, before + change_max))

    def _stopping_acceleration(self, distance: float) -> float:
        """Return the greatest acceleration that can drop to 0, by J·STEP per step, within a distance.

        With steps of length h, A = n·J·h + r (r < J·h) makes A·h + (A - J·h)·h + … = (n + 1)·A·h - J·h²·n·(n + 1)/2.
        """
        quantum = self._jerk * STEP * STEP
        n = math.floor(0.5 * (math.sqrt(1.0 + 8.0 * distance / quantum) - 1.0))
        return (distance / (n + 1) + 0.5 * n * quantum) / STEP


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
