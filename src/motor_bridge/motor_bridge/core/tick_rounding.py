"""Speeds of wheels in whole ticks a frame, without losing what is less than one."""

from __future__ import annotations

import math

from motor_bridge.core.wheel_base import TICKS_MAX


def clamp_ticks(left: float, right: float) -> tuple[float, float]:
    """Return both speeds, made smaller by one factor until they fit into 16 bits: the curvature is kept."""
    factor = min(1.0, TICKS_MAX / max(abs(left), abs(right), 1.0))
    return factor * left, factor * right


class TickRounding:
    """Chooses between the two whole numbers beside a speed so that the way comes out right in the end.

    The debt is the way that was wanted less the way that was commanded [ticks]; of both numbers the one is taken that
    leaves the smaller debt after one period: nothing is lost, what a late call left is paid back later.
    """

    def __init__(self, frame: float, period: float) -> None:
        """Owe nothing.

        Args:
            frame: in which ticks are counted [s].
            period: after which the next speed is expected [s].
        """
        self._frame, self._frames = frame, period / frame
        self.clear()

    def clear(self) -> None:
        """Forget the debt, with the wheel at rest."""
        self._debt = 0.0
        self._wanted = 0.0
        self._given = 0

    def round(self, wanted: float, elapsed: float) -> int:
        """Return the speed to be commanded now.

        Args:
            wanted: from now on [ticks a frame].
            elapsed: since the last call [s].
        """
        self._debt += (self._wanted - self._given) * elapsed / self._frame
        if wanted == 0.0 or wanted * self._wanted < 0.0:
            self._debt = 0.0  # what stands must not creep, and what is owed forwards is not paid backwards
        below = math.floor(wanted)
        choices = (below, below + 1) if wanted != below else (below,)
        self._given = min(choices, key=lambda given: abs(self._debt + (wanted - given) * self._frames))
        self._wanted = wanted
        return self._given
