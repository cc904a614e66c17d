"""Gain control: dark and full brightness of a lamp from its recent frames.

Both halves share one scale: with almost equal clocks one half may be sampled at its edges, neither dark nor full, for
seconds, but the other half is dark or full at that time.
"""

from __future__ import annotations

from collections import deque

import numpy as np
from numpy.typing import ArrayLike, NDArray

WINDOW_FRAMES = 120
FRAMES_MIN = 12
TAIL_FRACTION = 0.05
"""Quantile of the dark level, and 1 minus that of the bright level: small, because with almost equal clocks one of the
two may be sampled rarely."""
CONTRAST_MIN = 0.1
"""A lamp whose modulation is below this fraction of full light carries no code."""


class GainControl:
    """Normalizes the grey values of one lamp's halves for `UfsookDecoder`."""

    def __init__(self) -> None:
        self._history: deque[NDArray[np.float64]] = deque(maxlen=WINDOW_FRAMES)

    def normalize(self, grey: ArrayLike) -> NDArray[np.float64]:
        """Add a frame and return its brightness relative to full light, shape (2,), NaN while the gain is unknown.

        Args:
            grey: mean grey value of each half, shape (2,), any unit; NaN if not visible.
        """
        now = np.asarray(grey, float)
        if not np.isfinite(now).all():
            return np.full(2, np.nan)
        self._history.append(now)
        if len(self._history) < FRAMES_MIN:
            return np.full(2, np.nan)
        values = np.concatenate(self._history)
        tail = int(TAIL_FRACTION * len(values))
        ordered = np.partition(values, (tail, len(values) - 1 - tail))
        dark, bright = ordered[tail], ordered[len(values) - 1 - tail]
        if bright - dark <= CONTRAST_MIN * abs(bright):
            return np.full(2, np.nan)
        return (now - dark) / (bright - dark)
