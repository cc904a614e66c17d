"""Sightings in blocks: all sightings of a dot are in one block, so that blocks can be worked on one after the other."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, fields

import numpy as np
from numpy.typing import NDArray

from floor_localizer.core.survey.shelf import Shelf


@dataclass(frozen=True)
class Sightings:
    """Which image saw which dot in which direction.

    Attributes:
        image: shape (n,), index of the image.
        dot: shape (n,), index of the dot.
        directions: shape (n, 3), in the base frame of the level robot.
        sigmas: shape (n,), standard deviation on the floor along each axis [m].
        diameters: shape (n,), of the dots as they were seen [m].
    """

    image: NDArray[np.int64]
    dot: NDArray[np.int64]
    directions: NDArray[np.float64]
    sigmas: NDArray[np.float64]
    diameters: NDArray[np.float64]

    def where(self, kept: NDArray[np.bool_]) -> Sightings:
        """Return those sightings that are kept; the dots keep their indices."""
        return Sightings(*(getattr(self, field.name)[kept] for field in fields(self)))


@dataclass(frozen=True)
class SightingBlock:
    """Sightings of some dots.

    Attributes:
        seen: the sightings; their dots are those of the block.
        fixed_dots: shape (m, 2), dots of a map that must stay [m], NaN for dots that are to be found.
    """

    seen: Sightings
    fixed_dots: NDArray[np.float64]

    @property
    def is_fixed(self) -> NDArray[np.bool_]:
        """Which dots must stay, shape (m,)."""
        return np.isfinite(self.fixed_dots[:, 0])


class SightingBlocks:
    """Blocks on a shelf; blocks of neighbouring numbers lie side by side on the floor."""

    def __init__(self, shelf: Shelf, count: int) -> None:
        """Begin.

        Args:
            shelf: of the blocks.
            count: their number; each must be put before it is asked for.
        """
        self._shelf, self._count = shelf, count

    def __len__(self) -> int:
        """Return the number of blocks."""
        return self._count

    def __getitem__(self, number: int) -> SightingBlock:
        """Return a block."""
        *seen, fixed_dots = self._shelf.get('block', number)
        return SightingBlock(Sightings(*seen), fixed_dots)

    def __iter__(self) -> Iterator[SightingBlock]:
        """Yield all blocks in order."""
        return (self[number] for number in range(self._count))

    def put(self, number: int, block: SightingBlock) -> None:
        """Write a block, or write it anew."""
        seen = (getattr(block.seen, field.name) for field in fields(block.seen))
        self._shelf.put('block', number, *seen, block.fixed_dots)
