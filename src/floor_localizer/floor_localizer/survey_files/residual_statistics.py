"""Streaming statistics of residuals: a histogram instead of all values."""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

_BIN_WIDTH = 1e-8
"""Finer than the reported digits of a residual [m]."""


class LengthHistogram:
    """Histogram of lengths with bins of 10 nm, their rms and maximum."""

    def __init__(self) -> None:
        """Begin empty."""
        self._counts = np.zeros(1, dtype=np.int64)
        self._squares, self.maximum = 0.0, 0.0

    @property
    def count(self) -> int:
        """Number of lengths."""
        return int(self._counts.sum())

    @property
    def rms(self) -> float:
        """Root mean square of the lengths [m]."""
        return math.sqrt(self._squares / max(self.count, 1))

    def add(self, lengths: NDArray[np.float64]) -> None:
        """Add lengths, shape (n,) [m]."""
        counts = np.bincount((lengths / _BIN_WIDTH).astype(np.int64), minlength=len(self._counts))
        counts[: len(self._counts)] += self._counts
        self._counts = counts
        self._squares += float(np.sum(lengths**2))
        self.maximum = max(self.maximum, float(lengths.max(initial=0.0)))

    def quantile(self, fraction: float) -> float:
        """Return a quantile of the lengths [m]."""
        return _BIN_WIDTH * float(np.searchsorted(np.cumsum(self._counts), fraction * self.count))
