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

from floor_localizer.core.independent_tasks import OwnProcess, TaskRunner
from floor_localizer.core.survey.block_equations import block_equations
from floor_localizer.core.survey.elimination import Elimination
from floor_localizer.core.survey.equations import UNKNOWNS, Equations, unknowns_of
from floor_localizer.core.survey.placed_dots import place_dots
from floor_localizer.core.survey.shelf import MemoryShelf
from floor_localizer.core.survey.sighting_blocks import SightingBlock, SightingBlocks, Sightings

_ITERATIONS = 8
_CONVERGED = 1e-6
# Fixes the gauge where no dot is fixed, and keeps the matrix from being singular.
_GAUGE_SIGMA, _WEAKEST = 1e-7, 1e-3


@dataclass(frozen=True)
class Adjusted:
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
class BodyPriors:
    """Standard deviations of the robot body on its suspension, and the position of the camera.

    Attributes:
        position: optical centre in the base frame, shape (3,) [m].
        scale: standard deviation of the camera height, relative to it.
        tilt: standard deviation of roll and pitch [rad].
    """

    position: NDArray[np.float64]
    scale: float
    tilt: float


def adjust(
    sightings: Sightings,
    states: NDArray[np.float64],
    fixed_dots: NDArray[np.float64],
    priors: BodyPriors,
    iterations: int = _ITERATIONS,
) -> Adjusted:
    """Adjust images and dots that fit into one block; arguments as for `adjust_blocks`."""
    blocks, block = SightingBlocks(MemoryShelf(), 1), SightingBlock(sightings, fixed_dots)
    blocks.put(0, block)
    states = adjust_blocks(blocks, states, priors, OwnProcess(), iterations)
    return Adjusted(states, *place_dots(block, states, priors.position))


def adjust_blocks(
    blocks: SightingBlocks,
    states: NDArray[np.float64],
    priors: BodyPriors,
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
        the adjusted states, shape (k, 6); `place_dots` computes the dots from them.
    """
    elimination = Elimination(len(states), len(blocks), blocks.shelf, runner)
    spans, is_held = _spans(blocks, len(states))
    elimination.begin(spans)
    part = _BlockWithPriors(blocks, priors, is_held)
    for _ in range(iterations):
        blocks.shelf.put('states', 0, states)
        step = -elimination.solve(part)  # Gauss-Newton step
        states = states + step
        if np.abs(step[:, :3]).max() < _CONVERGED:
            break
    return states


def _spans(blocks: SightingBlocks, images: int) -> tuple[NDArray[np.int64], bool]:
    """Return the first and the last block that each image is in, shape (k, 2), and whether any dot is fixed."""
    spans, is_held = np.column_stack([np.full(images, len(blocks)), np.full(images, -1)]), False
    for number in range(len(blocks)):
        seeing, has_fixed = blocks.members(number)
        is_held |= has_fixed
        spans[seeing, 0] = np.minimum(spans[seeing, 0], number)
        spans[seeing, 1] = number
    return spans, is_held


@dataclass(frozen=True)
class _BlockWithPriors:
    """Returns the normal equations of a block, linearised at the states in the array store."""

    blocks: SightingBlocks
    priors: BodyPriors
    is_held: bool

    def __call__(self, number: int) -> Equations:
        states = self.blocks.shelf.look_up('states')
        part = block_equations(self.blocks[number], states, self.priors.position)
        # The prior of an image is added once, with the first block that observes it.
        new = np.flatnonzero(self.blocks.shelf.look_up('spans')[part.images, 0] == number)
        diagonal, pull = self._prior_terms(part.images[new], states)
        rows = unknowns_of(new)
        part.normal[rows, rows] += diagonal
        part.gradient[rows] += pull
        return part

    def _prior_terms(
        self, images: NDArray[np.int64], states: NDArray[np.float64]
    ) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
        weights = np.zeros((len(images), UNKNOWNS))
        weights[:, :3] = _WEAKEST
        weights[:, 3] = self.priors.scale**-2
        weights[:, 4:] = self.priors.tilt**-2
        pull = weights * states[images]
        pull[:, :3] = 0.0
        if not self.is_held:
            weights[images == 0, :3] = _GAUGE_SIGMA**-2
        return weights.ravel(), pull.ravel()
