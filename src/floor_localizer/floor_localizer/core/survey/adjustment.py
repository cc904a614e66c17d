"""All poses and all dots at once: sparse least squares (a bundle adjustment on a plane), block by block.

Each image k has the six unknowns of `pose_fit`, each dot j its place m_j. With the rays d_i of the sightings i,

    residual_i = p(state_k(i), d_i) - m_j(i),

the squared residuals over their variances, robust against false sightings (Huber), plus scale and tilts over theirs,
are least. As m_j enters with the unit matrix, the dots leave the normal equations by their weighted means (Schur):
what is left has six unknowns an image. All sightings of a dot are in one block, so a block is worked on without the
others, and `elimination` needs no more than what its images have to do with each other.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy import sparse

from floor_localizer.core.survey.elimination import UNKNOWNS, Elimination, Equations, unknowns_of
from floor_localizer.core.survey.shelf import MemoryShelf, Shelf
from floor_localizer.core.survey.sighting_blocks import SightingBlock, SightingBlocks, Sightings

_STEP = 1e-6
_HUBER = 2.5
_ITERATIONS = 8
_CONVERGED = 1e-6
# Fixes what the sightings leave open where nothing else is fixed, and keeps the matrix from being singular.
_GAUGE_SIGMA, _WEAKEST = 1e-7, 1e-3


@dataclass(frozen=True)
class Adjusted:
    """The result.

    Attributes:
        states: shape (k, 6), x, y [m], yaw [rad], scale, roll, pitch [rad] of each image.
        dots: shape (m, 2) [m].
        residuals: shape (n, 2), of the sightings [m].
    """

    states: NDArray[np.float64]
    dots: NDArray[np.float64]
    residuals: NDArray[np.float64]


@dataclass(frozen=True)
class BodyPriors:
    """How much the robot moves on its wheels: standard deviations, and where the camera is.

    Attributes:
        position: of the optical centre in the base frame, shape (3,) [m].
        scale: of the height as a share of it.
        tilt: of roll and pitch [rad].
    """

    position: NDArray[np.float64]
    scale: float
    tilt: float


def map_points(
    directions: NDArray[np.float64], position: NDArray[np.float64], states: NDArray[np.float64]
) -> NDArray[np.float64]:
    """Return where rays meet the floor in the map, shape (n, 2) [m].

    Args:
        directions: shape (n, 3), in the base frame of the level robot.
        position: shape (3,), optical centre of the level robot [m].
        states: shape (n, 6), one for each ray.
    """
    x, y, yaw, scale, roll, pitch = states.T
    d = _tilted(directions.T, roll, pitch)
    o = _tilted(np.broadcast_to(position[:, None], d.shape), roll, pitch)
    reach = -(o[2] + position[2] * scale) / d[2]
    px, py = o[0] + reach * d[0], o[1] + reach * d[1]
    cos, sin = np.cos(yaw), np.sin(yaw)
    return np.column_stack([x + cos * px - sin * py, y + sin * px + cos * py])


def _tilted(
    vectors: NDArray[np.float64], roll: NDArray[np.float64], pitch: NDArray[np.float64]
) -> NDArray[np.float64]:
    x, y, z = vectors
    y, z = np.cos(roll) * y - np.sin(roll) * z, np.sin(roll) * y + np.cos(roll) * z
    return np.stack([np.cos(pitch) * x + np.sin(pitch) * z, y, np.cos(pitch) * z - np.sin(pitch) * x])


def adjust(
    sightings: Sightings,
    states: NDArray[np.float64],
    fixed_dots: NDArray[np.float64],
    priors: BodyPriors,
    iterations: int = _ITERATIONS,
) -> Adjusted:
    """Adjust images and dots that are few enough for one block; arguments as of `adjust_blocks`."""
    shelf, block = MemoryShelf(), SightingBlock(sightings, fixed_dots)
    blocks = SightingBlocks(shelf, 1)
    blocks.put(0, block)
    states = adjust_blocks(blocks, states, priors, shelf, iterations)
    return Adjusted(states, *place_dots(block, states, priors.position))


def adjust_blocks(
    blocks: SightingBlocks,
    states: NDArray[np.float64],
    priors: BodyPriors,
    shelf: Shelf,
    iterations: int = _ITERATIONS,
) -> NDArray[np.float64]:
    """Adjust all images and dots.

    Args:
        blocks: what was seen; every image sees something.
        states: shape (k, 6), start; without fixed dots the first image stays where it is.
        priors: of the robot's body.
        shelf: for what does not fit into memory.
        iterations: at most.

    Returns:
        the adjusted states, shape (k, 6); `place_dots` tells the dots.
    """
    problem = _Problem(blocks, priors, len(states), shelf)
    for _ in range(iterations):
        step = problem.step(states)
        states = states + step
        if np.abs(step[:, :3]).max() < _CONVERGED:
            break
    return states


def place_dots(
    block: SightingBlock, states: NDArray[np.float64], position: NDArray[np.float64]
) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """Return the dots of a block, shape (m, 2), and the residuals of its sightings, shape (n, 2) [m]."""
    points = map_points(block.seen.directions, position, states[block.seen.image])
    dots = _weighted_dots(block, points, _weights(block, points))
    return dots, points - dots[block.seen.dot]


class _Problem:
    def __init__(self, blocks: SightingBlocks, priors: BodyPriors, images: int, shelf: Shelf) -> None:
        self._blocks, self._priors = blocks, priors
        self._first = np.full(images, len(blocks))
        last = np.full(images, -1)
        self._is_held = False
        for number, block in enumerate(blocks):
            self._is_held |= bool(block.is_fixed.any())
            self._first[block.seen.image] = np.minimum(self._first[block.seen.image], number)
            last[block.seen.image] = number
        self._elimination = Elimination(self._first, last, shelf)

    def step(self, states: NDArray[np.float64]) -> NDArray[np.float64]:
        """Return a Gauss-Newton step, shape (k, 6)."""
        return -self._elimination.solve(self._parts(states))

    def _parts(self, states: NDArray[np.float64]) -> Iterator[Equations]:
        for number, block in enumerate(self._blocks):
            part = _equations(block, states, self._priors.position)
            # What is known of an image's body beforehand counts once.
            new = np.flatnonzero(self._first[part.images] == number)
            diagonal, pull = self._prior_terms(part.images[new], states)
            rows = unknowns_of(new)
            part.normal[rows, rows] += diagonal
            part.gradient[rows] += pull
            yield part

    def _prior_terms(
        self, images: NDArray[np.int64], states: NDArray[np.float64]
    ) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
        weights = np.zeros((len(images), UNKNOWNS))
        weights[:, :3] = _WEAKEST
        weights[:, 3] = self._priors.scale**-2
        weights[:, 4:] = self._priors.tilt**-2
        pull = weights * states[images]
        pull[:, :3] = 0.0
        if not self._is_held:
            weights[images == 0, :3] = _GAUGE_SIGMA**-2
        return weights.ravel(), pull.ravel()


def _equations(block: SightingBlock, states: NDArray[np.float64], position: NDArray[np.float64]) -> Equations:
    """Return the normal equations of the images of a block, without its dots."""
    seen, number = block.seen, len(block.fixed_dots)
    images, image = np.unique(seen.image, return_inverse=True)
    each = states[seen.image]
    points = map_points(seen.directions, position, each)
    weights = _weights(block, points)
    residuals = points - _weighted_dots(block, points, weights)[seen.dot]
    jacobian = _jacobian(seen.directions, position, points, each)
    # Noise is in the image: from higher up it is larger on the floor. Without this term the map would shrink to
    # make its residuals small.
    jacobian[:, :, 3] -= residuals
    weighted = (jacobian * weights[:, None, None]).ravel()
    columns = np.repeat(unknowns_of(image).reshape(-1, 1, UNKNOWNS), 2, axis=1).ravel()
    rows = np.repeat(np.arange(2 * len(image)), UNKNOWNS)
    dot_rows = np.repeat((2 * seen.dot[:, None] + np.arange(2)).ravel(), UNKNOWNS)
    size = UNKNOWNS * len(images)
    J = sparse.csr_matrix((jacobian.ravel(), (rows, columns)), shape=(2 * len(image), size))
    WJ = sparse.csr_matrix((weighted, (rows, columns)), shape=(2 * len(image), size))
    M = sparse.csr_matrix((weighted, (dot_rows, columns)), shape=(2 * number, size))
    total = np.bincount(seen.dot, weights, number)
    free = np.where(block.is_fixed | (total == 0.0), 0.0, 1.0 / np.maximum(total, 1e-30))
    normal = J.T @ WJ - M.T @ sparse.diags(np.repeat(free, 2)) @ M
    # Of free dots the residuals' weighted sum is 0: the gradient needs no term of the dots.
    return Equations(images, normal.toarray(), np.asarray(WJ.T @ residuals.ravel()))


def _weighted_dots(
    block: SightingBlock, points: NDArray[np.float64], weights: NDArray[np.float64]
) -> NDArray[np.float64]:
    """Return the weighted means of the sightings; fixed dots stay."""
    dot, number = block.seen.dot, len(block.fixed_dots)
    total = np.maximum(np.bincount(dot, weights, number), 1e-30)
    means = np.column_stack([np.bincount(dot, weights * points[:, k], number) / total for k in range(2)])
    return np.where(block.is_fixed[:, None], block.fixed_dots, means)


def _weights(block: SightingBlock, points: NDArray[np.float64]) -> NDArray[np.float64]:
    """Return Huber's weights over the variances."""
    seen = block.seen
    dots = _weighted_dots(block, points, 1.0 / seen.sigmas**2)
    length = np.hypot(*(points - dots[seen.dot]).T) / seen.sigmas
    return np.minimum(1.0, _HUBER / np.maximum(length, 1e-12)) / seen.sigmas**2


def _jacobian(
    directions: NDArray[np.float64],
    position: NDArray[np.float64],
    points: NDArray[np.float64],
    each: NDArray[np.float64],
) -> NDArray[np.float64]:
    """Return the derivatives of the points by their image's state, shape (n, 2, 6)."""
    jacobian = np.empty((len(points), 2, UNKNOWNS))
    for unknown in range(UNKNOWNS):
        ahead = each.copy()
        ahead[:, unknown] += _STEP
        jacobian[:, :, unknown] = (map_points(directions, position, ahead) - points) / _STEP
    return jacobian


def without_outliers(block: SightingBlock, residuals: NDArray[np.float64], gate: float) -> SightingBlock:
    """Return the block without sightings whose residual is above ``gate`` standard deviations."""
    kept = np.hypot(*residuals.T) <= gate * block.seen.sigmas
    return SightingBlock(block.seen.where(kept), block.fixed_dots)
