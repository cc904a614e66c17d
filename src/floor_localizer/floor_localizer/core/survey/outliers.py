"""Reject outlier observations after an adjustment."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from floor_localizer.core.independent_tasks import TaskRunner, run_numbered
from floor_localizer.core.survey.placed_dots import place_dots
from floor_localizer.core.survey.sighting_blocks import BLOCKS_A_TASK, SightingBlock, SightingBlocks

_GATE = 8.0
"""Standard deviations."""


def drop_outliers(
    blocks: SightingBlocks, states: NDArray[np.float64], position: NDArray[np.float64], runner: TaskRunner
) -> None:
    """Drop observations whose residual exceeds the gate.

    Args:
        blocks: the observations; overwritten.
        states: states of all images, shape (k, 6).
        position: optical centre in the base frame, shape (3,) [m].
        runner: runs the tasks; they must see the blocks' array store.
    """
    blocks.shelf.put('states', 0, states)
    run_numbered(runner, _Dropping(blocks, position), len(blocks), BLOCKS_A_TASK)


@dataclass(frozen=True)
class _Dropping:
    blocks: SightingBlocks
    position: NDArray[np.float64]

    def __call__(self, number: int) -> None:
        block = self.blocks[number]
        _, residuals = place_dots(block, self.blocks.shelf.look_up('states'), self.position)
        kept = np.hypot(*residuals.T) <= _GATE * block.seen.sigmas
        self.blocks.put(number, SightingBlock(block.seen.where(kept), block.fixed_dots))
