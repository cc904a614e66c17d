"""All poses and all dots at once: sparse least squares (a bundle adjustment on a plane).

Each image k has the six unknowns of `pose_fit`, each dot j its place m_j. With the rays d_i of the sightings i,

    residual_i = p(state_k(i), d_i) - m_j(i),

the squared residuals over their variances, robust against false sightings (Huber), plus scale and tilts over theirs,
are least. As m_j enters with the unit matrix, the dots leave the normal equations by their weighted means (Schur):
what is left has six unknowns an image and is sparse, because only images with a dot in common meet in it.
"""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray
from scipy import sparse
from scipy.sparse.linalg import SuperLU, splu

UNKNOWNS = 6
_STEP = 1e-6
_HUBER = 2.5
_ITERATIONS = 8
_CONVERGED = 1e-6
# Fixes what the sightings leave open where nothing else is fixed, and keeps the matrix from being singular.
_GAUGE_SIGMA, _WEAKEST = 1e-7, 1e-3


@dataclass(frozen=True)
class Sightings:
    """Which image saw which dot in which direction.

    Attributes:
        image: shape (n,), index of the image.
        dot: shape (n,), index of the dot.
        directions: shape (n, 3), in the base frame of the level robot.
        sigmas: shape (n,), standard deviation on the floor along each axis [m].
        diameters: shape (n,), of the dots as they were seen [m].
    """

    image: NDArray[np.int64]
    dot: NDArray[np.int64]
    directions: NDArray[np.float64]
    sigmas: NDArray[np.float64]
    diameters: NDArray[np.float64]


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
    """Adjust all images and dots.

    Args:
        sightings: what was seen; every image sees something.
        states: shape (k, 6), start; without fixed dots the first image stays where it is.
        fixed_dots: shape (m, 2), dots of a map that must stay [m], NaN for dots that are to be found.
        priors: of the robot's body.
        iterations: at most.
    """
    problem = _Problem(sightings, fixed_dots, priors, len(states))
    for _ in range(iterations):
        step = problem.step(states)
        states = states + step
        if np.abs(step[:, :3]).max() < _CONVERGED:
            break
    points = map_points(sightings.directions, priors.position, states[sightings.image])
    weights = problem.weights(points, problem.dots(points, 1.0 / sightings.sigmas**2))
    dots = problem.dots(points, weights)
    return Adjusted(states, dots, points - dots[sightings.dot])


def factorise(normal: sparse.csc_matrix) -> SuperLU:
    """Return the factors of a sparse matrix that is symmetric (or Hermitian) and positive definite."""
    return splu(normal, permc_spec='MMD_AT_PLUS_A', diag_pivot_thresh=0.0, options={'SymmetricMode': True})


class _Problem:
    def __init__(
        self, sightings: Sightings, fixed_dots: NDArray[np.float64], priors: BodyPriors, images: int
    ) -> None:
        self._seen, self._fixed, self._priors, self._images = sightings, fixed_dots, priors, images
        self._is_fixed = np.isfinite(fixed_dots[:, 0])
        count = len(sightings.dot)
        columns = UNKNOWNS * sightings.image[:, None] + np.arange(UNKNOWNS)
        self._columns = np.repeat(columns[:, None, :], 2, axis=1).ravel()
        self._rows = np.repeat(np.arange(2 * count), UNKNOWNS)
        self._dot_rows = np.repeat((2 * sightings.dot[:, None] + np.arange(2)).ravel(), UNKNOWNS)

    def dots(self, points: NDArray[np.float64], weights: NDArray[np.float64]) -> NDArray[np.float64]:
        """Return the weighted means of the sightings; fixed dots stay."""
        dot, number = self._seen.dot, len(self._fixed)
        total = np.maximum(np.bincount(dot, weights, number), 1e-30)
        means = np.column_stack([np.bincount(dot, weights * points[:, k], number) / total for k in range(2)])
        return np.where(self._is_fixed[:, None], self._fixed, means)

    def weights(self, points: NDArray[np.float64], dots: NDArray[np.float64]) -> NDArray[np.float64]:
        """Return Huber's weights over the variances."""
        sigmas = self._seen.sigmas
        length = np.hypot(*(points - dots[self._seen.dot]).T) / sigmas
        return np.minimum(1.0, _HUBER / np.maximum(length, 1e-12)) / sigmas**2

    def step(self, states: NDArray[np.float64]) -> NDArray[np.float64]:
        """Return a Gauss-Newton step, shape (k, 6)."""
        seen, each = self._seen, states[self._seen.image]
        points = map_points(seen.directions, self._priors.position, each)
        jacobian = self._jacobian(points, each)
        weights = self.weights(points, self.dots(points, 1.0 / seen.sigmas**2))
        residuals = points - self.dots(points, weights)[seen.dot]
        # Noise is in the image: from higher up it is larger on the floor. Without this term the map would shrink to
        # make its residuals small.
        jacobian[:, :, 3] -= residuals
        size = UNKNOWNS * self._images
        weighted = (jacobian * weights[:, None, None]).ravel()
        shape = (2 * len(seen.dot), size)
        J = sparse.csr_matrix((jacobian.ravel(), (self._rows, self._columns)), shape=shape)
        WJ = sparse.csr_matrix((weighted, (self._rows, self._columns)), shape=shape)
        M = sparse.csr_matrix((weighted, (self._dot_rows, self._columns)), shape=(2 * len(self._fixed), size))
        total = np.bincount(seen.dot, weights, len(self._fixed))
        free = np.where(self._is_fixed | (total == 0.0), 0.0, 1.0 / np.maximum(total, 1e-30))
        normal = J.T @ WJ - M.T @ sparse.diags(np.repeat(free, 2)) @ M
        # Of free dots the residuals' weighted sum is 0: the gradient needs no term of the dots.
        gradient = WJ.T @ residuals.ravel()
        diagonal, pull = self._prior_terms(states)
        factor = factorise((normal + sparse.diags(diagonal)).tocsc())
        return -factor.solve(gradient + pull).reshape(-1, UNKNOWNS)

    def _jacobian(self, points: NDArray[np.float64], each: NDArray[np.float64]) -> NDArray[np.float64]:
        """Return the derivatives of the points by their image's state, shape (n, 2, 6)."""
        jacobian = np.empty((len(points), 2, UNKNOWNS))
        for unknown in range(UNKNOWNS):
            ahead = each.copy()
            ahead[:, unknown] += _STEP
            moved = map_points(self._seen.directions, self._priors.position, ahead)
            jacobian[:, :, unknown] = (moved - points) / _STEP
        return jacobian

    def _prior_terms(self, states: NDArray[np.float64]) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
        weights = np.zeros((self._images, UNKNOWNS))
        weights[:, :3] = _WEAKEST
        weights[:, 3] = self._priors.scale**-2
        weights[:, 4:] = self._priors.tilt**-2
        pull = weights * states
        pull[:, :3] = 0.0
        if not self._is_fixed.any():
            weights[0, :3] = _GAUGE_SIGMA**-2
        return weights.ravel(), pull.ravel()


def without_outliers(sightings: Sightings, residuals: NDArray[np.float64], gate: float) -> Sightings:
    """Return the sightings whose residual is not above ``gate`` standard deviations."""
    kept = np.hypot(*residuals.T) <= gate * sightings.sigmas
    return replace(
        sightings,
        image=sightings.image[kept],
        dot=sightings.dot[kept],
        directions=sightings.directions[kept],
        sigmas=sightings.sigmas[kept],
        diameters=sightings.diameters[kept],
    )
