"""Tiles of the plane with about the same number of images in each."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray


@dataclass(frozen=True)
class Tile:
    """Axis-aligned rectangle; infinite at the border of the floor.

    Attributes:
        lower: lower left corner, inclusive, shape (2,) [m].
        upper: upper right corner, exclusive, shape (2,) [m].
    """

    lower: NDArray[np.float64]
    upper: NDArray[np.float64]

    def contains(self, points: NDArray[np.float64]) -> NDArray[np.bool_]:
        """Return whether each point, shape (n, 2), is in the tile."""
        return np.asarray(((points >= self.lower) & (points < self.upper)).all(axis=1))

    def expanded(self, margin: float) -> Tile:
        """Return the tile expanded by a margin [m]."""
        return Tile(self.lower - margin, self.upper + margin)


def split_into_tiles(centres: NDArray[np.float64], capacity: int) -> list[Tile]:
    """Bisect the plane (k-d tree) until no tile contains more than ``capacity`` centres, shape (n, 2) [m].

    The tiles cover the plane without gaps, in the order of the tree's leaves, so consecutive tiles are neighbours.
    """
    halvings = 0
    while len(centres) > capacity << halvings:
        halvings += 1
    return _bisect(centres, Tile(np.full(2, -np.inf), np.full(2, np.inf)), halvings)


def _bisect(centres: NDArray[np.float64], tile: Tile, halvings: int) -> list[Tile]:
    if halvings == 0 or len(centres) == 0:
        return [tile]
    axis = int(np.argmax(np.ptp(centres, axis=0)))
    cut = float(np.median(centres[:, axis]))
    is_below = centres[:, axis] < cut
    upper, lower = tile.upper.copy(), tile.lower.copy()
    upper[axis] = lower[axis] = cut
    return [
        *_bisect(centres[is_below], Tile(tile.lower, upper), halvings - 1),
        *_bisect(centres[~is_below], Tile(lower, tile.upper), halvings - 1),
    ]
