"""Plausibility check of encoder counts against the possible wheel motion, since the serial line has no checksums."""

import math
from enum import Enum

import numpy as np
from numpy.typing import NDArray

from motor_bridge.core.controller_protocol import WheelCounts
from motor_bridge.core.diff_drive_kinematics import DiffDriveKinematics, DriveSettings, Velocity

RESTART_COUNT = 5
"""Consistent rejected counts in a row after which the encoders are taken as reset."""
COUNT_NOISE = 4.0
"""Noise of the difference of two counts [ticks]."""
_OVERSHOOT = 0.25  # greatest overshoot of the speed control, fraction
_RIPPLE = 3.0  # greatest ripple of the speed control [ticks per frame]
_PUSH_FACTOR = 2.0  # greatest speed of a pushed wheel, multiple of the maximum speed
_COAST_TIME = 0.5  # time in which motors without voltage come to rest [s]
_RESET_ROLL_TIME = 0.25  # their coasting distance, as time at full speed [s]
_CONTINUATION_FACTOR = 1.5  # two consistent counts differ by at most this multiple of the greatest turn
_Read = tuple[WheelCounts, float]  # with its time [s]


class WheelMotionBounds:
    """Bounds of the turns of both wheels since the last accepted counts [ticks].

    Bounds are arrays of shape (2, 2): least and greatest turn (rows) of the left and the right wheel (columns).
    """

    _low: NDArray[np.float64]
    _high: NDArray[np.float64]

    def __init__(self, kinematics: DiffDriveKinematics, settings: DriveSettings) -> None:
        self._frame, self._auto_stop = kinematics.frame, settings.auto_stop
        self.apply_settings(kinematics, settings)
        self._ripple = _RIPPLE / kinematics.frame
        self._commanded = np.zeros(2)
        self.start((0.0, 0.0))

    def apply_settings(self, kinematics: DiffDriveKinematics, settings: DriveSettings) -> None:
        """Use other velocity limits."""
        fastest = kinematics.to_wheel_ticks(Velocity(settings.max_linear_velocity, -settings.max_angular_velocity))[0]
        self._pushed_speed_max = _PUSH_FACTOR * fastest / kinematics.frame

    def set_commanded(self, left: int, right: int) -> None:
        """Set the commanded speeds [ticks per frame]."""
        self._commanded = np.array([left, right]) / self._frame
        self._low = np.minimum(self._low, self._commanded)
        self._high = np.maximum(self._high, self._commanded)

    def start(self, speeds: tuple[float, float]) -> None:
        """Restart at accepted counts, with the measured speeds of the wheels [ticks/s]."""
        self._low = np.minimum(speeds, self._commanded)
        self._high = np.maximum(speeds, self._commanded)

    def commanded_bounds(self, elapsed: float) -> NDArray[np.float64]:
        """Return the bounds some time [s] after the last accepted counts, while the controller follows the commands."""
        return self._bounds(self._low, self._high, elapsed)

    def link_lost_bounds(self, elapsed: float) -> NDArray[np.float64]:
        """Return the bounds without a link: the auto-stop ends every motion at an unknown time."""
        time = min(elapsed, self._auto_stop + _COAST_TIME)
        return self._bounds(np.minimum(self._low, 0.0), np.maximum(self._high, 0.0), time)

    def reset_bounds(self) -> NDArray[np.float64]:
        """Return the bounds of the counts after a reset of the controller: the wheels coast from count 0."""
        return self._bounds(np.minimum(self._low, 0.0), np.maximum(self._high, 0.0), _RESET_ROLL_TIME)

    def pushed_turn_max(self, elapsed: float) -> float:
        """Return the greatest turn of a wheel, even if it is pushed [ticks]."""
        return self._pushed_speed_max * elapsed + COUNT_NOISE

    def _bounds(self, low: NDArray[np.float64], high: NDArray[np.float64], elapsed: float) -> NDArray[np.float64]:
        tolerance = self._ripple * elapsed + COUNT_NOISE
        least = low * np.where(low < 0.0, 1.0 + _OVERSHOOT, 1.0 - _OVERSHOOT) * elapsed - tolerance
        most = high * np.where(high > 0.0, 1.0 + _OVERSHOOT, 1.0 - _OVERSHOOT) * elapsed + tolerance
        return np.array([least, most])


def is_within_bounds(turns: tuple[int, int], bounds: NDArray[np.float64]) -> bool:
    """Return whether the turns of both wheels [ticks] are within their bounds."""
    return bool((bounds[0] <= turns).all() and (turns <= bounds[1]).all())


def max_abs_turns(bounds: NDArray[np.float64]) -> tuple[float, float]:
    """Return the greatest absolute turn of the left and the right wheel [ticks]."""
    left, right = np.max(np.abs(bounds), axis=0)
    return math.ceil(left), math.ceil(right)


class CountStatus(Enum):
    """Outcome of the check of encoder counts."""

    ACCEPTED = 'accepted'
    RETRY = 'implausible, read again'
    REJECTED = 'rejected, the wheels cannot have turned so far'
    RESTARTED = 'restarted after a jump of the encoders'


class EncoderMonitor:
    """Checks counts against the possible motion of the wheels since the last accepted ones.

    Attributes:
        last_accepted: last accepted counts and their time [s], None before the first.
    """

    def __init__(self, bounds: WheelMotionBounds) -> None:
        self._bounds = bounds
        self.last_accepted: _Read | None = None
        self._unconfirmed: _Read | None = None
        self._rejected: _Read | None = None
        self._rejected_in_row = 0

    def start(self, counts: WheelCounts, now: float) -> None:
        """Accept counts."""
        self.last_accepted, self._unconfirmed, self._rejected = (counts, now), None, None
        self._rejected_in_row = 0

    def check(self, counts: WheelCounts, now: float) -> CountStatus:
        """Check counts that were read at a time [s] against the last accepted ones.

        A wheel that is pushed or stuck does not follow its commands: such counts are read again at once, and accepted
        if both reads are consistent.
        """
        if self.last_accepted is None:
            self.start(counts, now)
            return CountStatus.ACCEPTED
        # The wheels followed their commands, or were pushed and a second read confirms it.
        difference = count_difference(self.last_accepted[0], counts)
        elapsed = max(0.0, now - self.last_accepted[1])
        is_reachable = max(map(abs, difference)) <= self._bounds.pushed_turn_max(elapsed)
        if is_within_bounds(difference, self._bounds.commanded_bounds(elapsed)) or (
            is_reachable and self._is_continuation(self._unconfirmed, counts, now)
        ):
            self.start(counts, now)
            return CountStatus.ACCEPTED
        # Otherwise read once more; counts that a second read confirms may be those of reset encoders.
        if self._unconfirmed is None:
            self._unconfirmed = counts, now
            return CountStatus.RETRY
        confirmed = self._is_continuation(self._unconfirmed, counts, now)
        self._unconfirmed = None
        return self._reject(counts, now) if confirmed else CountStatus.REJECTED

    def _reject(self, counts: WheelCounts, now: float) -> CountStatus:
        is_continued = self._is_continuation(self._rejected, counts, now)
        self._rejected_in_row = self._rejected_in_row + 1 if is_continued else 1
        self._rejected = counts, now
        return CountStatus.RESTARTED if self._rejected_in_row >= RESTART_COUNT else CountStatus.REJECTED

    def _is_continuation(self, before: _Read | None, counts: WheelCounts, now: float) -> bool:
        """Return whether counts are consistent with earlier ones."""
        if before is None:
            return False
        elapsed = max(0.0, now - before[1])
        limit = _CONTINUATION_FACTOR * (self._bounds.pushed_turn_max(elapsed) - COUNT_NOISE) + COUNT_NOISE
        return max(map(abs, count_difference(before[0], counts))) <= limit


def count_difference(before: WheelCounts, after: WheelCounts) -> tuple[int, int]:
    """Return the differences of the counts [ticks], modulo 2^32 with the least absolute value."""
    half = 1 << 31
    left, right = (
        (new - old + half) % (2 * half) - half for old, new in ((before.left, after.left), (before.right, after.right))
    )
    return left, right
