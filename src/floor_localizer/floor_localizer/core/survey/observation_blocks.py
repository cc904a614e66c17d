"""Observations in blocks: all observations of a dot are in one block, so blocks can be processed independently."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from floor_localizer.core.survey.array_store import ArrayStore

BLOCKS_PER_TASK = 4
"""Blocks processed in one task: enough to hide the overhead of scheduling."""


@dataclass(frozen=True)
class Observations:
    """Observations of dots in images.

    Attributes:
        image: index of the image, shape (n,).
        dot: index of the dot, shape (n,); -1 before observations are merged into dots.
        directions: ray directions in the base frame of the level robot, shape (n, 3).
        sigmas: standard deviation on the floor along each axis, shape (n,) [m].
        diameters: observed diameters of the dots, shape (n,) [m].
    """

    image: NDArray[np.int64]
    dot: NDArray[np.int64]
    directions: NDArray[np.float64]
    sigmas: NDArray[np.float64]
    diameters: NDArray[np.float64]

    @property
    def arrays(self) -> tuple[NDArray[Any], ...]:
        """All attributes, in order."""
        return self.image, self.dot, self.directions, self.sigmas, self.diameters

    def where(self, kept: NDArray[np.bool_]) -> Observations:
        """Return the observations selected by a mask, shape (n,); the dots keep their indices."""
        return Observations(*(array[kept] for array in self.arrays))


@dataclass(frozen=True)
class ObservationBlock:
    """All observations of some dots.

    Attributes:
        observations: the observations; their dot numbers count within the block.
        fixed_dots: positions of fixed dots, shape (m, 2) [m]; NaN for dots to be estimated.
    """

    observations: Observations
    fixed_dots: NDArray[np.float64]

    @property
    def is_fixed(self) -> NDArray[np.bool_]:
        """Whether each dot is fixed, shape (m,)."""
        return np.isfinite(self.fixed_dots[:, 0])


@dataclass(frozen=True)
class ObservationBlocks:
    """Blocks in an array store; blocks with neighbouring numbers are neighbours on the floor.

    Attributes:
        store: array store of the blocks.
        count: number of blocks; each must be written before it is read.
    """

    store: ArrayStore
    count: int

    def __len__(self) -> int:
        """Return the number of blocks."""
        return self.count

    def __getitem__(self, number: int) -> ObservationBlock:
        """Return a block."""
        *observations, fixed_dots = self.store.get('block', number)
        return ObservationBlock(Observations(*observations), fixed_dots)

    def __iter__(self) -> Iterator[ObservationBlock]:
        """Yield all blocks in order."""
        return (self[number] for number in range(self.count))

    def put(self, number: int, block: ObservationBlock) -> None:
        """Write or overwrite a block."""
        self.store.put('block', number, *block.observations.arrays, block.fixed_dots)
        self.store.put('members', number, np.unique(block.observations.image), np.array(block.is_fixed.any()))

    def observing_images(self, number: int) -> tuple[NDArray[np.int64], bool]:
        """Return the images that observe dots of a block, ascending, and whether any of its dots is fixed."""
        images, has_fixed = self.store.get('members', number)
        return images, bool(has_fixed)
