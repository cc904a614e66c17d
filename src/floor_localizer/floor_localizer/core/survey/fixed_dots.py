"""Identify the dots of a survey that are in the map to extend; they keep their position."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from floor_localizer.core.independent_tasks import TaskRunner, run_numbered
from floor_localizer.core.survey.dot_matching import nearest_pairs
from floor_localizer.core.survey.old_dots import OldDots
from floor_localizer.core.survey.placed_dots import place_dots
from floor_localizer.core.survey.sighting_blocks import BLOCKS_A_TASK, SightingBlock, SightingBlocks


def fix_dots(
    blocks: SightingBlocks,
    states: NDArray[np.float64],
    position: NDArray[np.float64],
    old: OldDots,
    reach: float,
    runner: TaskRunner,
) -> None:
    """Fix the dots that match dots of the existing map, one to one; the nearest dot wins.

    Args:
        blocks: blocks without fixed dots; overwritten.
        states: states of all images, shape (k, 6).
        position: optical centre in the base frame, shape (3,) [m].
        old: dots of the existing map.
        reach: largest distance of a match [m].
        runner: runs the tasks; they must see the blocks' array store.
    """
    shelf = blocks.shelf
    shelf.put('states', 0, states)
    run_numbered(runner, _Pairing(blocks, position, old, reach), len(blocks), BLOCKS_A_TASK)
    pairs = [shelf.get('pairs', number) for number in range(len(blocks))]
    block = np.repeat(np.arange(len(blocks)), [len(which) for which, _ in pairs])
    which, distance = (np.concatenate(column) for column in zip(*pairs, strict=True))
    order = np.lexsort((block, distance, which))
    _, first = np.unique(which[order], return_index=True)
    is_nearest = np.zeros(len(which), dtype=np.bool_)
    is_nearest[order[first]] = True
    for number in range(len(blocks)):
        shelf.put('nearest', number, is_nearest[block == number])
    run_numbered(runner, _Fixing(blocks), len(blocks), BLOCKS_A_TASK)


@dataclass(frozen=True)
class _Pairing:
    """Stores the pairs of dots of a block and of the existing map: index in the map, and distance."""

    blocks: SightingBlocks
    position: NDArray[np.float64]
    old: OldDots
    reach: float

    def __call__(self, number: int) -> None:
        shelf = self.blocks.shelf
        dots, _ = place_dots(self.blocks[number], shelf.look_up('states'), self.position)
        which, points = self.old.around(dots, self.reach)
        dot_indices, near = nearest_pairs(points, dots, self.reach)
        shelf.put('pairs', number, which[near], np.hypot(*(dots[dot_indices] - points[near]).T))
        shelf.put('paired', number, dot_indices, points[near])


@dataclass(frozen=True)
class _Fixing:
    """Fixes the dots of a block that are the nearest to their dot of the existing map among all blocks."""

    blocks: SightingBlocks

    def __call__(self, number: int) -> None:
        shelf, block = self.blocks.shelf, self.blocks[number]
        (is_nearest,), (dot_indices, points) = shelf.get('nearest', number), shelf.get('paired', number)
        fixed = block.fixed_dots.copy()
        fixed[dot_indices[is_nearest]] = points[is_nearest]
        self.blocks.put(number, SightingBlock(block.seen, fixed))
