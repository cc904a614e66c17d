"""What dark and full light of a lamp's halves look like to the camera, from what it saw of late."""

from __future__ import annotations

from collections import deque

import numpy as np
from numpy.typing import ArrayLike, NDArray

FRAMES = 120
FRAMES_MIN = 12
TAIL = 0.1
"""Share of the frames that are darker than dark or brighter than bright: the halves' light is on or off for the most."""
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
        count = len(self._seen)
        if count < FRAMES_MIN:
            return np.full(2, np.nan)
        tail = int(TAIL * count)
        ordered = np.partition(np.array(self._seen), (tail, count - 1 - tail), axis=0)
        dark, bright = ordered[tail], ordered[count - 1 - tail]
        if (bright - dark <= CONTRAST_MIN * np.abs(bright)).any():
            return np.full(2, np.nan)
        return (now - dark) / (bright - dark)
