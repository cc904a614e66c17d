"""Identify the dots of a survey that are in the map to extend; they keep their position."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from floor_localizer.core.independent_tasks import TaskRunner, run_indexed
from floor_localizer.core.survey.dot_estimation import estimate_dots
from floor_localizer.core.survey.dot_matching import nearest_pairs
from floor_localizer.core.survey.existing_dots import ExistingDots
from floor_localizer.core.survey.observation_blocks import (
    BLOCKS_PER_TASK,
    ObservationBlock,
    ObservationBlocks,
)


def fix_dots(
    blocks: ObservationBlocks,
    states: NDArray[np.float64],
    position: NDArray[np.float64],
    existing_dots: ExistingDots,
    max_distance: float,
    runner: TaskRunner,
) -> None:
    """Fix the dots that match dots of the existing map, one to one; the nearest dot wins.

    Args:
        blocks: blocks without fixed dots; overwritten.
        states: states of all images, shape (k, 6).
        position: optical centre in the base frame, shape (3,) [m].
        existing_dots: dots of the existing map.
        max_distance: largest distance of a match [m].
        runner: runs the tasks; they must see the blocks' array store.
    """
    store = blocks.store
    store.put('states', 0, states)
    run_indexed(
        runner, _PairTask(blocks, position, existing_dots, max_distance), len(blocks), BLOCKS_PER_TASK
    )
    pairs = [store.get('pairs', number) for number in range(len(blocks))]
    block = np.repeat(np.arange(len(blocks)), [len(existing_indices) for existing_indices, _ in pairs])
    existing_indices, distance = (np.concatenate(column) for column in zip(*pairs, strict=True))
    order = np.lexsort((block, distance, existing_indices))
    _, first = np.unique(existing_indices[order], return_index=True)
    is_nearest = np.zeros(len(existing_indices), dtype=np.bool_)
    is_nearest[order[first]] = True
    for number in range(len(blocks)):
        store.put('nearest', number, is_nearest[block == number])
    run_indexed(runner, _FixTask(blocks), len(blocks), BLOCKS_PER_TASK)


@dataclass(frozen=True)
class _PairTask:
    """Stores the pairs of dots of a block and of the existing map: index in the map, and distance."""

    blocks: ObservationBlocks
    position: NDArray[np.float64]
    existing_dots: ExistingDots
    max_distance: float

    def __call__(self, number: int) -> None:
        store = self.blocks.store
        dots, _ = estimate_dots(self.blocks[number], store.memory_map('states'), self.position)
        existing_indices, points = self.existing_dots.query(dots, self.max_distance)
        dot_indices, near = nearest_pairs(points, dots, self.max_distance)
        store.put('pairs', number, existing_indices[near], np.hypot(*(dots[dot_indices] - points[near]).T))
        store.put('paired', number, dot_indices, points[near])


@dataclass(frozen=True)
class _FixTask:
    """Fixes the dots of a block that are the nearest to their dot of the existing map among all blocks."""

    blocks: ObservationBlocks

    def __call__(self, number: int) -> None:
        store, block = self.blocks.store, self.blocks[number]
        (is_nearest,), (dot_indices, points) = store.get('nearest', number), store.get('paired', number)
        fixed = block.fixed_dots.copy()
        fixed[dot_indices[is_nearest]] = points[is_nearest]
        self.blocks.put(number, ObservationBlock(block.observations, fixed))
