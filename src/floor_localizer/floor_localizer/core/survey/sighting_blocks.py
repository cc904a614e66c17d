"""Sightings in blocks: all sightings of a dot are in one block, so that blocks can be worked on one after the other."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from floor_localizer.core.survey.shelf import Shelf

BLOCKS_A_TASK = 4
"""Of tasks on blocks: it takes longer than to hand it out."""


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

    @property
    def arrays(self) -> tuple[NDArray[Any], ...]:
        """All attributes, in their order."""
        return self.image, self.dot, self.directions, self.sigmas, self.diameters

    def where(self, kept: NDArray[np.bool_]) -> Sightings:
        """Return those sightings that are kept; the dots keep their indices."""
        return Sightings(*(array[kept] for array in self.arrays))


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


@dataclass(frozen=True)
class SightingBlocks:
    """Blocks on a shelf; blocks of neighbouring numbers lie side by side on the floor.

    Attributes:
        shelf: of the blocks.
        count: their number; each must be put before it is asked for.
    """

    shelf: Shelf
    count: int

    def __len__(self) -> int:
        """Return the number of blocks."""
        return self.count

    def __getitem__(self, number: int) -> SightingBlock:
        """Return a block."""
        *seen, fixed_dots = self.shelf.get('block', number)
        return SightingBlock(Sightings(*seen), fixed_dots)

    def __iter__(self) -> Iterator[SightingBlock]:
        """Yield all blocks in order."""
        return (self[number] for number in range(self.count))

    def put(self, number: int, block: SightingBlock) -> None:
        """Write a block, or write it anew."""
        self.shelf.put('block', number, *block.seen.arrays, block.fixed_dots)
        self.shelf.put('members', number, np.unique(block.seen.image), np.array(block.is_fixed.any()))

    def members(self, number: int) -> tuple[NDArray[np.int64], bool]:
        """Return the images that see something of a block, rising, and whether any of its dots must stay."""
        images, has_fixed = self.shelf.get('members', number)
        return images, bool(has_fixed)
