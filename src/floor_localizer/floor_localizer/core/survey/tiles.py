"""Tiles of the plane with about as many images in each."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray


@dataclass(frozen=True)
class Tile:
    """A rectangle, infinite where the floor ends.

    Attributes:
        lower: shape (2,), its lower left corner, which belongs to it [m].
        upper: shape (2,), its upper right corner, which does not [m].
    """

    lower: NDArray[np.float64]
    upper: NDArray[np.float64]

    def contains(self, points: NDArray[np.float64]) -> NDArray[np.bool_]:
        """Tell which points, shape (n, 2), lie in it."""
        return np.asarray(((points >= self.lower) & (points < self.upper)).all(axis=1))

    def grown(self, by: float) -> Tile:
        """Return the tile with a margin [m]."""
        return Tile(self.lower - by, self.upper + by)


def cut_tiles(centres: NDArray[np.float64], most: int) -> list[Tile]:
    """Halve the plane until no tile holds more than ``most`` centres, shape (n, 2) [m].

    The tiles are without gaps; those that make a larger one by twos, by fours, and so on follow each other.
    """
    halvings = 0
    while len(centres) > most << halvings:
        halvings += 1
    return _halved(centres, Tile(np.full(2, -np.inf), np.full(2, np.inf)), halvings)


def _halved(centres: NDArray[np.float64], tile: Tile, halvings: int) -> list[Tile]:
    if halvings == 0 or len(centres) == 0:
        return [tile]
    axis = int(np.argmax(np.ptp(centres, axis=0)))
    cut = float(np.median(centres[:, axis]))
    is_below = centres[:, axis] < cut
    upper, lower = tile.upper.copy(), tile.lower.copy()
    upper[axis] = lower[axis] = cut
    return [
        *_halved(centres[is_below], Tile(tile.lower, upper), halvings - 1),
        *_halved(centres[~is_below], Tile(lower, tile.upper), halvings - 1),
    ]
