"""What dark and full light of a lamp look like to the camera, from what it saw of late.

Both halves share one scale: clocks that hardly differ show one half at its edges, neither dark nor full, for seconds,
but the other is dark or full just then.
"""

from __future__ import annotations

from collections import deque

import numpy as np
from numpy.typing import ArrayLike, NDArray

FRAMES = 120
FRAMES_MIN = 12
TAIL = 0.05
"""Share of the values that are darker than dark, and of those that are brighter than bright: small, for a clock that
hardly differs may show one of both rarely."""
CONTRAST_MIN = 0.1
"""A lamp whose light changes by less than this share of its full light carries no code."""


class BrightnessScale:
    """Scales the grey values of one lamp's halves to what `UfsookDecoder` takes."""

    def __init__(self) -> None:
        self._seen: deque[NDArray[np.float64]] = deque(maxlen=FRAMES)

    def scaled(self, grey: ArrayLike) -> NDArray[np.float64]:
        """Take a frame and return its brightness over full light, shape (2,), NaN while that is not known.

        Args:
            grey: shape (2,), mean grey value of each half, in any unit; NaN where it was not seen.
        """
        now = np.asarray(grey, float)
        if not np.isfinite(now).all():
            return np.full(2, np.nan)
        self._seen.append(now)
        if len(self._seen) < FRAMES_MIN:
            return np.full(2, np.nan)
        values = np.concatenate(self._seen)
        tail = int(TAIL * len(values))
        ordered = np.partition(values, (tail, len(values) - 1 - tail))
        dark, bright = ordered[tail], ordered[len(values) - 1 - tail]
        if bright - dark <= CONTRAST_MIN * abs(bright):
            return np.full(2, np.nan)
        return (now - dark) / (bright - dark)
