"""Bundle adjustment of all image poses and dots on a plane: sparse least squares, block by block.

Each image k has the six unknowns of `pose_fit`, each dot j its position m_j. With the rays d_i of the observations i,

    residual_i = p(state_k(i), d_i) - m_j(i),

the sum of the squared residuals over their variances (Huber loss), plus scale and tilts over theirs, is minimised.
The Jacobian by m_j is the identity, so the Schur complement replaces each dot by the weighted mean of its
observations and six unknowns per image remain. All observations of a dot are in one block, so any process that can
read the array store can build the equations of a block; `elimination` solves their sum.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from floor_localizer.core.independent_tasks import InProcessRunner, TaskRunner
from floor_localizer.core.survey.array_store import MemoryArrayStore
from floor_localizer.core.survey.block_equations import block_equations
from floor_localizer.core.survey.dot_estimation import estimate_dots
from floor_localizer.core.survey.multifrontal_solver import MultifrontalSolver
from floor_localizer.core.survey.normal_equations import UNKNOWNS_PER_IMAGE, NormalEquations, unknown_indices
from floor_localizer.core.survey.observation_blocks import ObservationBlock, ObservationBlocks, Observations

_ITERATIONS = 8
_CONVERGENCE_TOLERANCE = 1e-6
# Fixes the gauge where no dot is fixed, and keeps the matrix from being singular.
_GAUGE_SIGMA, _MIN_WEIGHT = 1e-7, 1e-3


@dataclass(frozen=True)
class AdjustmentResult:
    """Result of a bundle adjustment.

    Attributes:
        states: shape (k, 6), x, y [m], yaw [rad], scale, roll, pitch [rad] of each image.
        dots: positions of the dots, shape (m, 2) [m].
        residuals: residuals of the observations, shape (n, 2) [m].
    """

    states: NDArray[np.float64]
    dots: NDArray[np.float64]
    residuals: NDArray[np.float64]


@dataclass(frozen=True)
class SuspensionPriors:
    """Standard deviations of the robot body on its suspension, and the position of the camera.

    Attributes:
        position: optical centre in the base frame, shape (3,) [m].
        scale: standard deviation of the camera height, relative to it.
        tilt: standard deviation of roll and pitch [rad].
    """

    position: NDArray[np.float64]
    scale: float
    tilt: float


def bundle_adjust(
    observations: Observations,
    states: NDArray[np.float64],
    fixed_dots: NDArray[np.float64],
    priors: SuspensionPriors,
    iterations: int = _ITERATIONS,
) -> AdjustmentResult:
    """Adjust images and dots that fit into one block; arguments as for `bundle_adjust_blocks`."""
    blocks, block = ObservationBlocks(MemoryArrayStore(), 1), ObservationBlock(observations, fixed_dots)
    blocks.put(0, block)
    states = bundle_adjust_blocks(blocks, states, priors, InProcessRunner(), iterations)
    return AdjustmentResult(states, *estimate_dots(block, states, priors.position))


def bundle_adjust_blocks(
    blocks: ObservationBlocks,
    states: NDArray[np.float64],
    priors: SuspensionPriors,
    runner: TaskRunner,
    iterations: int = _ITERATIONS,
) -> NDArray[np.float64]:
    """Adjust all images and dots.

    Args:
        blocks: the observations; every image observes at least one dot.
        states: initial states, shape (k, 6); without fixed dots the first image keeps its pose.
        priors: priors of the robot body.
        runner: runs the tasks; they must see the blocks' array store. It does not change the result.
        iterations: maximum number of iterations.

    Returns:
        the adjusted states, shape (k, 6); `estimate_dots` computes the dots from them.
    """
    solver = MultifrontalSolver(len(states), len(blocks), blocks.store, runner)
    spans, is_gauge_fixed = _spans(blocks, len(states))
    solver.set_spans(spans)
    part = _PosteriorEquations(blocks, priors, is_gauge_fixed)
    for _ in range(iterations):
        blocks.store.put('states', 0, states)
        step = -solver.solve(part)  # Gauss-Newton step
        states = states + step
        if np.abs(step[:, :3]).max() < _CONVERGENCE_TOLERANCE:
            break
    return states


def _spans(blocks: ObservationBlocks, images: int) -> tuple[NDArray[np.int64], bool]:
    """Return the first and the last block that each image is in, shape (k, 2), and whether any dot is fixed."""
    spans, is_gauge_fixed = np.column_stack([np.full(images, len(blocks)), np.full(images, -1)]), False
    for number in range(len(blocks)):
        observing, has_fixed = blocks.observing_images(number)
        is_gauge_fixed |= has_fixed
        spans[observing, 0] = np.minimum(spans[observing, 0], number)
        spans[observing, 1] = number
    return spans, is_gauge_fixed


@dataclass(frozen=True)
class _PosteriorEquations:
    """Returns the normal equations of a block, linearised at the states in the array store."""

    blocks: ObservationBlocks
    priors: SuspensionPriors
    is_gauge_fixed: bool

    def __call__(self, number: int) -> NormalEquations:
        states = self.blocks.store.memory_map('states')
        part = block_equations(self.blocks[number], states, self.priors.position)
        # The prior of an image is added once, with the first block that observes it.
        new = np.flatnonzero(self.blocks.store.memory_map('spans')[part.images, 0] == number)
        diagonal, prior_gradient = self._prior_terms(part.images[new], states)
        rows = unknown_indices(new)
        part.normal[rows, rows] += diagonal
        part.gradient[rows] += prior_gradient
        return part

    def _prior_terms(
        self, images: NDArray[np.int64], states: NDArray[np.float64]
    ) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
        weights = np.zeros((len(images), UNKNOWNS_PER_IMAGE))
        weights[:, :3] = _MIN_WEIGHT
        weights[:, 3] = self.priors.scale**-2
        weights[:, 4:] = self.priors.tilt**-2
        prior_gradient = weights * states[images]
        prior_gradient[:, :3] = 0.0
        if not self.is_gauge_fixed:
            weights[images == 0, :3] = _GAUGE_SIGMA**-2
        return weights.ravel(), prior_gradient.ravel()
