"""A hall of any size: its dots strip by strip, as CSV and around a place, without holding them all."""

from __future__ import annotations

import math
from pathlib import Path

import numpy as np
from numba import njit
from numpy.typing import NDArray

from floor_localizer.files.csv_format import HEADER

DENSITY = 5384.0
# Dots lie on a lattice, no two on the same place [m].
_STEP = 2e-5
_STRIP_DOTS = 500_000
_STRIPS_PER_ROW = 10


class Hall:
    """A square hall of evenly random dots."""

    def __init__(self, dots: int, seed: int) -> None:
        """Describe it: nothing is drawn yet."""
        self._seed = seed
        self._strips = max(round(dots / _STRIP_DOTS), 1)
        self._per_strip = dots // self._strips
        self.dots = self._per_strip * self._strips
        self.side = math.sqrt(dots / DENSITY)
        self._columns = int(self.side / _STEP)
        self._rows = int(self.side / self._strips / _STEP)
        self._kept: dict[int, NDArray[np.int64]] = {}

    def strip(self, number: int) -> NDArray[np.int64]:
        """Return the dots of one strip on the lattice, shape (n, 2), in random order."""
        rng = np.random.default_rng([self._seed, self._strips, number])
        places = np.empty(0, dtype=np.int64)
        while len(places) < self._per_strip:
            more = rng.integers(0, self._columns * self._rows, self._per_strip - len(places))
            places = np.unique(np.concatenate([places, more]))
        row, column = np.divmod(rng.permutation(places), self._columns)
        return np.column_stack([column, row + number * self._rows])

    def around(self, x: float, y: float, reach: float) -> NDArray[np.float64]:
        """Return the dots in a square of half this width around a place, shape (n, 2) [m]."""
        height = self._rows * _STEP
        first = max(int((y - reach) / height), 0)
        last = min(int((y + reach) / height), self._strips - 1)
        dots = np.vstack([self._cached_strip(number) for number in range(first, last + 1)]) * _STEP
        return dots[(np.abs(dots - (x, y)) < reach).all(axis=1)]

    def places(self, number: int, margin: float) -> NDArray[np.float64]:
        """Return places all over the hall but near its walls, ten side by side, shape (number, 2) [m]."""
        rng = np.random.default_rng([self._seed, number])
        low, high = margin, self.side - margin
        rows = np.linspace(low, high, -(-number // _STRIPS_PER_ROW)).repeat(_STRIPS_PER_ROW)[:number]
        return np.column_stack([rng.uniform(low, high, number), rows])

    def _cached_strip(self, number: int) -> NDArray[np.int64]:
        if number not in self._kept:
            if len(self._kept) > 1:
                self._kept.pop(next(iter(self._kept)))
            self._kept[number] = self.strip(number)
        return self._kept[number]

    def write(self, path: Path) -> None:
        """Write it as CSV."""
        buffer = np.empty(64 * self._per_strip, dtype=np.uint8)
        with path.open('wb') as file:
            file.write(f'{HEADER}\n'.encode())
            for number in range(self._strips):
                file.write(buffer[: _format(self.strip(number), buffer)].tobytes())


@njit(cache=True)
def _format(dots: NDArray[np.int64], buffer: NDArray[np.uint8]) -> int:
    """Write dots on the lattice as lines with five decimals, and return how many bytes that took."""
    end = 0
    for dot in dots:
        for place in dot:
            hundredths = 2 * place  # of a millimetre
            digits = 6
            while hundredths >= 10**digits:
                digits += 1
            for k in range(digits - 1, -1, -1):
                buffer[end] = 48 + hundredths // 10**k % 10
                end += 1
                if k == 5:
                    buffer[end] = 46
                    end += 1
            buffer[end] = 44
            end += 1
        buffer[end] = 10
        end += 1
    return end
