"""How large residuals are, counted without keeping them."""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

_BIN = 1e-8
"""Finer than anything that is told of a residual [m]."""


class LengthCounter:
    """Counts lengths in bins of 10 nm."""

    def __init__(self) -> None:
        """Begin with none."""
        self._counts = np.zeros(1, dtype=np.int64)
        self._squares, self.most = 0.0, 0.0

    @property
    def number(self) -> int:
        """How many were counted."""
        return int(self._counts.sum())

    @property
    def rms(self) -> float:
        """Their root mean square [m]."""
        return math.sqrt(self._squares / max(self.number, 1))

    def add(self, lengths: NDArray[np.float64]) -> None:
        """Count lengths, shape (n,) [m]."""
        counts = np.bincount((lengths / _BIN).astype(np.int64), minlength=len(self._counts))
        counts[: len(self._counts)] += self._counts
        self._counts = counts
        self._squares += float(np.sum(lengths**2))
        self.most = max(self.most, float(lengths.max(initial=0.0)))

    def below(self, share: float) -> float:
        """Return the length that a share of them is not above [m]."""
        return _BIN * float(np.searchsorted(np.cumsum(self._counts), share * self.number))
