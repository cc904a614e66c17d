"""Bundle adjustment of all image poses and dots on a plane: sparse least squares, block by block.

Each image k has the six unknowns of `pose_fit`, each dot j its position m_j. With the rays d_i of the observations i,

    residual_i = p(state_k(i), d_i) - m_j(i),

the sum of the squared residuals over their variances (Huber loss), plus scale and tilts over theirs, is minimised.
The Jacobian by m_j is the identity, so the Schur complement replaces each dot by the weighted mean of its
observations and six unknowns per image remain. All observations of a dot are in one block, so any process that can
read the array store can build the equations of a block; `multifrontal_solver` solves their sum.
"""

from dataclasses import dataclass

import numpy as np
from scipy import sparse

from floor_localizer.core.arrays import Floats, Ints
from floor_localizer.core.independent_tasks import InProcessRunner, TaskRunner
from floor_localizer.core.survey.adjustment.multifrontal_solver import (
    UNKNOWNS_PER_IMAGE,
    MultifrontalSolver,
    NormalEquations,
    unknown_indices,
)
from floor_localizer.core.survey.adjustment.observations import (
    ObservationBlock,
    ObservationBlocks,
    Observations,
    project_rays_to_map,
)
from floor_localizer.core.survey.adjustment.surveyed_dots import estimate_dots, huber_weights, weighted_means
from floor_localizer.core.survey.array_store import MemoryArrayStore

_STEP = 1e-6
_ITERATIONS = 8
_CONVERGENCE_TOLERANCE = 1e-6
# Fixes the gauge where no dot is fixed, and keeps the matrix from being singular.
_GAUGE_SIGMA, _MIN_WEIGHT = 1e-7, 1e-3


def block_equations(block: ObservationBlock, states: Floats, position: Floats) -> NormalEquations:
    """Return the normal equations of a block, without its dots."""
    observations, number = block.observations, len(block.fixed_dots)
    images, image = np.unique(observations.image, return_inverse=True)
    image_states = states[observations.image]
    points = project_rays_to_map(observations.directions, position, image_states)
    weights = huber_weights(block, points)
    residuals = points - weighted_means(block, points, weights)[observations.dot]
    jacobian = _jacobian(observations.directions, position, points, image_states)
    # The noise is in the image, so it grows on the floor with the camera height. Without this term the map would
    # shrink to reduce its residuals.
    jacobian[:, :, 3] -= residuals
    weighted = (jacobian * weights[:, None, None]).ravel()
    columns = np.repeat(unknown_indices(image).reshape(-1, 1, UNKNOWNS_PER_IMAGE), 2, axis=1).ravel()
    rows = np.repeat(np.arange(2 * len(image)), UNKNOWNS_PER_IMAGE)
    dot_rows = np.repeat((2 * observations.dot[:, None] + np.arange(2)).ravel(), UNKNOWNS_PER_IMAGE)
    size = UNKNOWNS_PER_IMAGE * len(images)
    J = sparse.csr_matrix((jacobian.ravel(), (rows, columns)), shape=(2 * len(image), size))
    WJ = sparse.csr_matrix((weighted, (rows, columns)), shape=(2 * len(image), size))
    dot_projection = sparse.csr_matrix((weighted, (dot_rows, columns)), shape=(2 * number, size))
    total = np.bincount(observations.dot, weights, number)
    free = np.where(block.is_fixed | (total == 0.0), 0.0, 1.0 / np.maximum(total, 1e-30))
    normal = J.T @ WJ - dot_projection.T @ sparse.diags(np.repeat(free, 2)) @ dot_projection
    # The weighted residuals of a free dot sum to 0, so the gradient needs no term for the dots.
    return NormalEquations(images, normal.toarray(), np.asarray(WJ.T @ residuals.ravel()))


def _jacobian(directions: Floats, position: Floats, points: Floats, image_states: Floats) -> Floats:
    """Return the derivatives of the points by the state of their image, shape (n, 2, 6), by finite differences."""
    jacobian = np.empty((len(points), 2, UNKNOWNS_PER_IMAGE))
    for unknown in range(UNKNOWNS_PER_IMAGE):
        stepped = image_states.copy()
        stepped[:, unknown] += _STEP
        jacobian[:, :, unknown] = (project_rays_to_map(directions, position, stepped) - points) / _STEP
    return jacobian


@dataclass(frozen=True)
class AdjustmentResult:
    """Result: states of the images, (k, 6), dots, (m, 2) [m], and residuals of the observations, (n, 2) [m]."""

    states: Floats
    dots: Floats
    residuals: Floats


@dataclass(frozen=True)
class SuspensionPriors:
    """Standard deviations of the robot body on its suspension, and the position of the camera.

    Attributes:
        position: optical centre in the base frame, shape (3,) [m].
        scale: standard deviation of the camera height, relative to it.
        tilt: standard deviation of roll and pitch [rad].
    """

    position: Floats
    scale: float
    tilt: float


def bundle_adjust(
    observations: Observations,
    states: Floats,
    fixed_dots: Floats,
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
    states: Floats,
    priors: SuspensionPriors,
    runner: TaskRunner,
    iterations: int = _ITERATIONS,
) -> Floats:
    """Return the states after adjusting all images and dots; `estimate_dots` computes the dots from them.

    Args:
        blocks: the observations; every image observes at least one dot.
        states: initial states; without fixed dots the first image keeps its pose.
        priors: priors of the robot body.
        runner: runs the tasks; it does not change the result.
        iterations: maximum number of iterations.
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


def _spans(blocks: ObservationBlocks, images: int) -> tuple[Ints, bool]:
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

    def _prior_terms(self, images: Ints, states: Floats) -> tuple[Floats, Floats]:
        weights = np.zeros((len(images), UNKNOWNS_PER_IMAGE))
        weights[:, :3] = _MIN_WEIGHT
        weights[:, 3] = self.priors.scale**-2
        weights[:, 4:] = self.priors.tilt**-2
        prior_gradient = weights * states[images]
        prior_gradient[:, :3] = 0.0
        if not self.is_gauge_fixed:
            weights[images == 0, :3] = _GAUGE_SIGMA**-2
        return weights.ravel(), prior_gradient.ravel()
