"""Project observations to the map and estimate the dots from them.

A ray d of an image with the state x, y, yaw, scale, roll, pitch meets the floor at p(state, d). A dot is the weighted
mean of its observations, robust against outliers (Huber), or its fixed position.
"""

from __future__ import annotations

import numpy as np

from floor_localizer.core.arrays import Floats
from floor_localizer.core.independent_tasks import TaskRunner
from floor_localizer.core.survey.adjustment.observations import (
    ObservationBlock,
    ObservationBlocks,
    project_rays_to_map,
)

_HUBER = 2.5
_OUTLIER_GATE = 8.0  # [standard deviations]


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


def drop_outliers(blocks: ObservationBlocks, states: Floats, position: Floats, runner: TaskRunner) -> None:
    """Drop observations whose residual exceeds the gate; the blocks are overwritten."""
    blocks.store.put('states', 0, states)
    blocks.for_each(runner, _drop_of_block, position)


def _drop_of_block(blocks: ObservationBlocks, position: Floats, number: int) -> None:
    block = blocks[number]
    _, residuals = estimate_dots(block, blocks.store.memory_map('states'), position)
    kept = np.hypot(*residuals.T) <= _OUTLIER_GATE * block.observations.sigmas
    blocks.put(number, ObservationBlock(block.observations.where(kept), block.fixed_dots))
