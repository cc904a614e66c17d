"""The pose that explains the rays to lamps best, with its Cramér-Rao covariance."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from shirube_geometry import LevelCamera, PlanarPose, wrap_angle
from vlc_beacon.core.pose.bearing_model import projections_with_jacobian
from vlc_beacon.core.pose.known_states import KnownStates
from vlc_beacon.core.pose.lamp_rays import LampRays
from vlc_beacon.core.pose.pose_fix import PLANAR, ExpectedPose
from vlc_beacon.core.pose.settings import PoseSettings

STEPS_MAX = 12
STEP_DONE = 1e-7
"""A step smaller than this [m, rad] ends the search."""
DETERMINANT_MIN = 1e-10
"""Of the information, scaled to a diagonal of ones, below which it does not determine the state."""


@dataclass(frozen=True)
class PoseEstimate:
    """A state that was fitted to rays.

    Attributes:
        state: shape (6,), see `bearing_model`.
        covariance: shape (6, 6), of the state, zero where it is known.
        residuals: shape (n, 2), of all sightings, in standard deviations.
        in_front: shape (n,), which lamps are before the camera.
    """

    state: NDArray[np.float64]
    covariance: NDArray[np.float64]
    residuals: NDArray[np.float64]
    in_front: NDArray[np.bool_]

    @property
    def distances(self) -> NDArray[np.float64]:
        """Shape (n,), lengths of the residuals; infinite for lamps behind the camera."""
        return np.where(self.in_front, np.hypot(self.residuals[:, 0], self.residuals[:, 1]), np.inf)

    @property
    def pose(self) -> PlanarPose:
        """``T_map_base``."""
        return PlanarPose(float(self.state[0]), float(self.state[1]), float(self.state[3]))

    def distance_from(self, expected: ExpectedPose) -> float:
        """Return how many standard deviations the pose is away from an expected one."""
        return expected.distance_of(self.pose, self.covariance[PLANAR])

    def is_within(self, distance: float, other: PoseEstimate) -> bool:
        """Tell whether no part of the state is farther than this from another's [m, rad]."""
        apart = self.state - other.state
        apart[3] = wrap_angle(float(apart[3]))
        return bool(np.abs(apart).max() < distance)


class PoseLeastSquares:
    """Rays to lamps at known places."""

    def __init__(
        self,
        rays: LampRays,
        lamps: NDArray[np.float64],
        camera: LevelCamera,
        known: KnownStates,
        settings: PoseSettings,
    ) -> None:
        """Take what is seen.

        Args:
            rays: n sightings.
            lamps: shape (n, 3), their places in the map frame [m].
            camera: where it is on the robot.
            known: what of the pose is given.
            settings: how exactly lamps and tilt are known.
        """
        self.rays = rays
        self.lamps = lamps
        self.covariances = rays.covariances(settings.pixel_sigma)
        self._camera = camera
        self._settings = settings
        self._free = known.free(tilt=settings.tilt_sigma > 0.0)

    def evaluate(self, state: NDArray[np.float64]) -> PoseEstimate:
        """Return what a state leaves unexplained; its covariance is left zero."""
        residuals, _, depths = self._whitened(state)
        return PoseEstimate(state, np.zeros((len(state), len(state))), residuals, depths > 0.0)

    def refine(self, state: NDArray[np.float64], used: NDArray[np.bool_]) -> PoseEstimate | None:
        """Fit the state by Gauss-Newton steps.

        Args:
            state: shape (6,), where to begin.
            used: shape (n,), the sightings that count.

        Returns:
            the estimate, None where the sightings do not determine the state.
        """
        inverse: NDArray[np.float64] | None = None
        for _ in range(STEPS_MAX):
            residuals, jacobian, _ = self._whitened(state)
            rows = jacobian[used].reshape(-1, len(state))
            information = rows.T @ rows
            gradient = rows.T @ residuals[used].ravel()
            if self._settings.tilt_sigma > 0.0:
                information[[4, 5], [4, 5]] += self._settings.tilt_sigma**-2
                gradient[4:] -= state[4:] * self._settings.tilt_sigma**-2
            inner = information[np.ix_(self._free, self._free)]
            inverse = _inverse(inner)
            if inverse is None:
                return None
            step = np.zeros(len(state))
            step[self._free] = inverse @ gradient[self._free]
            state = state + step
            if np.abs(step).max() < STEP_DONE:
                break
        state[3] = wrap_angle(float(state[3]))
        covariance = np.zeros((len(state), len(state)))
        covariance[np.ix_(self._free, self._free)] = inverse
        residuals, _, depths = self._whitened(state)
        return PoseEstimate(state, covariance, residuals, depths > 0.0)

    def _whitened(
        self, state: NDArray[np.float64]
    ) -> tuple[NDArray[np.float64], NDArray[np.float64], NDArray[np.float64]]:
        """Return residuals (n, 2) and Jacobian (n, 2, 6) in standard deviations, and depths (n,) [m]."""
        seen, jacobian, depths = projections_with_jacobian(state, self.lamps, self.rays.motions, self._camera)
        spread = self._settings.beacon_sigma / np.maximum(depths, 0.1)
        covariances = self.covariances + (spread**2)[:, None, None] * np.eye(2)
        roots = _inverse_roots(covariances)
        residuals = (roots @ (self.rays.rays - seen)[:, :, None])[:, :, 0]
        return residuals, roots @ jacobian, depths


def _inverse_roots(covariances: NDArray[np.float64]) -> NDArray[np.float64]:
    """Return lower triangular W with ``W C W^T = 1``, shape (n, 2, 2)."""
    a = np.sqrt(covariances[:, 0, 0])
    b = covariances[:, 1, 0] / a
    c = np.sqrt(np.maximum(covariances[:, 1, 1] - b**2, 1e-24))
    roots = np.zeros_like(covariances)
    roots[:, 0, 0], roots[:, 1, 1] = 1.0 / a, 1.0 / c
    roots[:, 1, 0] = -b / (a * c)
    return roots


def _inverse(information: NDArray[np.float64]) -> NDArray[np.float64] | None:
    """Return the inverse of a symmetric matrix, None where it has none."""
    diagonal = np.diag(information)
    if not np.isfinite(information).all() or not (diagonal > 0.0).all():
        return None
    scale = 1.0 / np.sqrt(diagonal)
    scaled = information * scale * scale[:, None]
    if np.linalg.det(scaled) < DETERMINANT_MIN:
        return None
    return np.asarray(np.linalg.inv(scaled) * scale * scale[:, None])
