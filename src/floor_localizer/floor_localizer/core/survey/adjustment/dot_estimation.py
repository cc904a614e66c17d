"""Project observations to the map and estimate the dots from them.

A ray d of an image with the state x, y, yaw, scale, roll, pitch meets the floor at p(state, d). A dot is the weighted
mean of its observations, robust against outliers (Huber), or its fixed position.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from floor_localizer.core.arrays import Floats
from floor_localizer.core.independent_tasks import TaskRunner, run_indexed
from floor_localizer.core.survey.adjustment.observations import (
    BLOCKS_PER_TASK,
    ObservationBlock,
    ObservationBlocks,
    project_rays_to_map,
)

_HUBER = 2.5


def estimate_dots(block: ObservationBlock, states: Floats, position: Floats) -> tuple[Floats, Floats]:
    """Return the dots of a block, shape (m, 2), and the residuals of its observations, shape (n, 2) [m]."""
    points = project_rays_to_map(block.observations.directions, position, states[block.observations.image])
    dots = weighted_means(block, points, huber_weights(block, points))
    return dots, points - dots[block.observations.dot]


def weighted_means(block: ObservationBlock, points: Floats, weights: Floats) -> Floats:
    """Return the weighted means of the observations of each dot; fixed dots keep their position."""
    dot, number = block.observations.dot, len(block.fixed_dots)
    total = np.maximum(np.bincount(dot, weights, number), 1e-30)
    means = np.column_stack([np.bincount(dot, weights * points[:, k], number) / total for k in range(2)])
    return np.where(block.is_fixed[:, None], block.fixed_dots, means)


def huber_weights(block: ObservationBlock, points: Floats) -> Floats:
    """Return the Huber weights divided by the variances, shape (n,)."""
    observations = block.observations
    dots = weighted_means(block, points, 1.0 / observations.sigmas**2)
    length = np.hypot(*(points - dots[observations.dot]).T) / observations.sigmas
    return np.minimum(1.0, _HUBER / np.maximum(length, 1e-12)) / observations.sigmas**2


_GATE = 8.0
"""Standard deviations."""


def drop_outliers(blocks: ObservationBlocks, states: Floats, position: Floats, runner: TaskRunner) -> None:
    """Drop observations whose residual exceeds the gate; the blocks are overwritten."""
    blocks.store.put('states', 0, states)
    run_indexed(runner, _DropTask(blocks, position), len(blocks), BLOCKS_PER_TASK)


@dataclass(frozen=True)
class _DropTask:
    blocks: ObservationBlocks
    position: Floats

    def __call__(self, number: int) -> None:
        block = self.blocks[number]
        _, residuals = estimate_dots(block, self.blocks.store.memory_map('states'), self.position)
        kept = np.hypot(*residuals.T) <= _GATE * block.observations.sigmas
        self.blocks.put(number, ObservationBlock(block.observations.where(kept), block.fixed_dots))
