"""Rounding of wheel speeds to whole ticks per frame with error accumulation."""

from __future__ import annotations

import math

from motor_bridge.core.diff_drive_kinematics import TICKS_MAX


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
        """Start with no error.

        Args:
            frame: control period of the firmware [s].
            period: expected time between two calls [s].
        """
        self._frame, self._frames = frame, period / frame
        self.clear()

    def clear(self) -> None:
        """Reset the error, with the wheel at rest."""
        self._error = 0.0
        self._target = 0.0
        self._commanded = 0

    def round(self, target: float, elapsed: float) -> int:
        """Return the speed to command now [ticks per frame].

        Args:
            target: target speed from now on [ticks per frame].
            elapsed: time since the last call [s].
        """
        self._error += (self._target - self._commanded) * elapsed / self._frame
        if target == 0.0 or target * self._target < 0.0:
            self._error = 0.0  # a stopped wheel must not turn, and the error is not carried over a reversal
        below = math.floor(target)
        choices = (below, below + 1) if target != below else (below,)
        self._commanded = min(
            choices, key=lambda commanded: abs(self._error + (target - commanded) * self._frames)
        )
        self._target = target
        return self._commanded
