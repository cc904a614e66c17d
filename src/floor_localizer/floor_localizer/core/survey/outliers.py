"""Reject outlier observations after an adjustment."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from floor_localizer.core.independent_tasks import TaskRunner, run_indexed
from floor_localizer.core.survey.dot_estimation import estimate_dots
from floor_localizer.core.survey.observation_blocks import (
    BLOCKS_PER_TASK,
    ObservationBlock,
    ObservationBlocks,
)

_GATE = 8.0
"""Standard deviations."""


def drop_outliers(
    blocks: ObservationBlocks, states: NDArray[np.float64], position: NDArray[np.float64], runner: TaskRunner
) -> None:
    """Drop observations whose residual exceeds the gate.

    Args:
        blocks: the observations; overwritten.
        states: states of all images, shape (k, 6).
        position: optical centre in the base frame, shape (3,) [m].
        runner: runs the tasks; they must see the blocks' array store.
    """
    blocks.store.put('states', 0, states)
    run_indexed(runner, _DropTask(blocks, position), len(blocks), BLOCKS_PER_TASK)


@dataclass(frozen=True)
class _DropTask:
    blocks: ObservationBlocks
    position: NDArray[np.float64]

    def __call__(self, number: int) -> None:
        block = self.blocks[number]
        _, residuals = estimate_dots(block, self.blocks.store.memory_map('states'), self.position)
        kept = np.hypot(*residuals.T) <= _GATE * block.observations.sigmas
        self.blocks.put(number, ObservationBlock(block.observations.where(kept), block.fixed_dots))
