"""Least-squares pose from rays to lamps, with its Cramér-Rao covariance."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from shirube_core.geometry import SE2, SE3, covariance_from_information, matrix_from_rpy, wrap_angle
from vlc_beacon.core.pose.lamp_rays import LampRays
from vlc_beacon.core.pose.pose_fix import PLANAR, ExpectedPose
from vlc_beacon.core.settings import PoseSettings

STATES = 6
_ROTATION_90 = np.array([[0.0, -1.0], [1.0, 0.0]])


def camera_points(
    state: NDArray[np.float64], lamps: NDArray[np.float64], motions: NDArray[np.float64], camera: SE3
) -> NDArray[np.float64]:
    """Return the lamp positions, shape (n, 3), in the optical frame [m]; ``motions`` as in `LampRays`."""
    tilted = _level_points(state, lamps, motions) @ _tilt_matrix(state)
    return np.asarray((tilted - camera.position) @ camera.rotation)


def projections_with_jacobian(
    state: NDArray[np.float64], lamps: NDArray[np.float64], motions: NDArray[np.float64], camera: SE3
) -> tuple[NDArray[np.float64], NDArray[np.float64], NDArray[np.float64]]:
    """Return the rays to the lamps, their Jacobian and the depths; arguments as in `camera_points`.

    Returns:
        rays with z = 1, shape (n, 2); their Jacobian with respect to the state, shape (n, 2, 6); depths, shape (n,)
        [m], not positive for lamps behind the camera.
    """
    level = _level_points(state, lamps, motions)
    tilt = _tilt_matrix(state)
    tilted = level @ tilt
    points = (tilted - camera.position) @ camera.rotation
    pose_derivatives = _level_derivatives(state, level, motions) @ tilt
    zero = np.zeros(len(lamps))
    turned_x = np.column_stack([zero, tilted[:, 2], -tilted[:, 1]])
    turned_y = np.column_stack([-tilted[:, 2], zero, tilted[:, 0]])
    changes = np.concatenate([pose_derivatives, turned_x[:, None], turned_y[:, None]], axis=1) @ camera.rotation
    depths = points[:, 2]
    safe = np.where(np.abs(depths) > 1e-9, depths, 1e-9)
    rays = points[:, :2] / safe[:, None]
    jacobian = (changes[:, :, :2] - rays[:, None, :] * changes[:, :, 2:]) / safe[:, None, None]
    return rays, jacobian.transpose(0, 2, 1), depths


def _level_points(
    state: NDArray[np.float64], lamps: NDArray[np.float64], motions: NDArray[np.float64]
) -> NDArray[np.float64]:
    """Return the lamps in the level frame at the time of each observation, shape (n, 3)."""
    x, y, z, yaw = state[:4]
    cos, sin = math.cos(yaw), math.sin(yaw)
    ahead = (lamps[:, :2] - (x, y)) @ np.array([[cos, -sin], [sin, cos]]) - motions[:, :2]
    turn_cos, turn_sin = np.cos(motions[:, 2]), np.sin(motions[:, 2])
    return np.column_stack(
        [
            turn_cos * ahead[:, 0] + turn_sin * ahead[:, 1],
            turn_cos * ahead[:, 1] - turn_sin * ahead[:, 0],
            lamps[:, 2] - z,
        ]
    )


def _level_derivatives(
    state: NDArray[np.float64], level: NDArray[np.float64], motions: NDArray[np.float64]
) -> NDArray[np.float64]:
    """Return the derivatives of the points in the level frame with respect to x, y, z and yaw, shape (n, 4, 3)."""
    angles = state[3] + motions[:, 2]
    cos, sin = np.cos(angles), np.sin(angles)
    turn_cos, turn_sin = np.cos(motions[:, 2]), np.sin(motions[:, 2])
    # Translation to the position of the observation, in the level frame at that time.
    offset_x = turn_cos * motions[:, 0] + turn_sin * motions[:, 1]
    offset_y = turn_cos * motions[:, 1] - turn_sin * motions[:, 0]
    derivatives = np.zeros((len(level), 4, 3))
    derivatives[:, 0, 0], derivatives[:, 0, 1] = -cos, sin
    derivatives[:, 1, 0], derivatives[:, 1, 1] = -sin, -cos
    derivatives[:, 2, 2] = -1.0
    lever_arm = level[:, :2] + np.column_stack([offset_x, offset_y])
    derivatives[:, 3, :2] = lever_arm @ _ROTATION_90
    return derivatives


def _tilt_matrix(state: NDArray[np.float64]) -> NDArray[np.float64]:
    """Return ``exp(tilt)``; for small errors roll and pitch commute."""
    if not state[4:].any():
        return np.eye(3)
    return matrix_from_rpy((state[4], state[5], 0.0))


STEPS_MAX = 12
STEP_TOLERANCE = 1e-7
"""Step that ends the iteration [m, rad]."""
DETERMINANT_MIN = 1e-10
"""Minimum determinant of the information matrix scaled to a unit diagonal."""


@dataclass(frozen=True)
class PoseEstimate:
    """A state fitted to rays.

    Attributes:
        state: pose state, shape (6,), see `bearing_model`.
        covariance: covariance of the state, shape (6, 6), zero for known components.
        residuals: normalized residuals of all observations, shape (n, 2) [standard deviations].
        in_front: mask of the lamps in front of the camera, shape (n,).
    """

    state: NDArray[np.float64]
    covariance: NDArray[np.float64]
    residuals: NDArray[np.float64]
    in_front: NDArray[np.bool_]

    @property
    def distances(self) -> NDArray[np.float64]:
        """Norms of the residuals, shape (n,); infinite for lamps behind the camera."""
        return np.where(self.in_front, np.hypot(self.residuals[:, 0], self.residuals[:, 1]), np.inf)

    @property
    def pose(self) -> SE2:
        """``T_map_base``."""
        return SE2(float(self.state[0]), float(self.state[1]), float(self.state[3]))

    def mahalanobis_distance_to(self, expected: ExpectedPose) -> float:
        """Return the Mahalanobis distance from an expected pose."""
        return expected.mahalanobis_distance(self.pose, self.covariance[PLANAR])

    def is_within(self, distance: float, other: PoseEstimate) -> bool:
        """Return whether all components of the states differ by less than a distance [m, rad]."""
        difference = self.state - other.state
        difference[3] = wrap_angle(float(difference[3]))
        return bool(np.abs(difference).max() < distance)


class PoseLeastSquares:
    """Least-squares problem of rays to lamps at known positions."""

    def __init__(
        self,
        rays: LampRays,
        lamps: NDArray[np.float64],
        camera: SE3,
        known_height: float | None,
        settings: PoseSettings,
    ) -> None:
        """Set the observations.

        Args:
            rays: n observations.
            lamps: lamp positions in the map frame, shape (n, 3) [m].
            camera: gravity-aligned camera pose on the robot.
            known_height: height of the base in the map frame [m], None if it is estimated.
            settings: standard deviations of lamps and tilt.
        """
        self.rays = rays
        self.lamps = lamps
        self.covariances = rays.covariances(settings.pixel_sigma)
        self._camera = camera
        self._settings = settings
        self._free = np.array([True, True, known_height is None, True, *[settings.tilt_sigma > 0.0] * 2])

    def evaluate(self, state: NDArray[np.float64]) -> PoseEstimate:
        """Return the residuals of a state; its covariance is left zero."""
        residuals, _, depths = self._whitened_residuals(state)
        return PoseEstimate(state, np.zeros((len(state), len(state))), residuals, depths > 0.0)

    def refine(self, state: NDArray[np.float64], used: NDArray[np.bool_]) -> PoseEstimate | None:
        """Fit the state by Gauss-Newton iterations.

        Args:
            state: initial state, shape (6,).
            used: mask of the used observations, shape (n,).

        Returns:
            the estimate, None if the observations do not determine the state.
        """
        inverse: NDArray[np.float64] | None = None
        for _ in range(STEPS_MAX):
            residuals, jacobian, _ = self._whitened_residuals(state)
            rows = jacobian[used].reshape(-1, len(state))
            information = rows.T @ rows
            gradient = rows.T @ residuals[used].ravel()
            if self._settings.tilt_sigma > 0.0:
                information[[4, 5], [4, 5]] += self._settings.tilt_sigma**-2
                gradient[4:] -= state[4:] * self._settings.tilt_sigma**-2
            inner = information[np.ix_(self._free, self._free)]
            inverse = covariance_from_information(inner, DETERMINANT_MIN)
            if inverse is None:
                return None
            step = np.zeros(len(state))
            step[self._free] = inverse @ gradient[self._free]
            state = state + step
            if np.abs(step).max() < STEP_TOLERANCE:
                break
        state[3] = wrap_angle(float(state[3]))
        covariance = np.zeros((len(state), len(state)))
        covariance[np.ix_(self._free, self._free)] = inverse
        residuals, _, depths = self._whitened_residuals(state)
        return PoseEstimate(state, covariance, residuals, depths > 0.0)

    def _whitened_residuals(
        self, state: NDArray[np.float64]
    ) -> tuple[NDArray[np.float64], NDArray[np.float64], NDArray[np.float64]]:
        """Return whitened residuals (n, 2) and Jacobian (n, 2, 6), and depths (n,) [m]."""
        seen, jacobian, depths = projections_with_jacobian(state, self.lamps, self.rays.motions, self._camera)
        position_sigma = self._settings.beacon_sigma / np.maximum(depths, 0.1)
        covariances = self.covariances + (position_sigma**2)[:, None, None] * np.eye(2)
        roots = _inverse_square_roots(covariances)
        residuals = (roots @ (self.rays.rays - seen)[:, :, None])[:, :, 0]
        return residuals, roots @ jacobian, depths


def _inverse_square_roots(covariances: NDArray[np.float64]) -> NDArray[np.float64]:
    """Return lower triangular W with ``W C W^T = I``, shape (n, 2, 2)."""
    a = np.sqrt(covariances[:, 0, 0])
    b = covariances[:, 1, 0] / a
    c = np.sqrt(np.maximum(covariances[:, 1, 1] - b**2, 1e-24))
    roots = np.zeros_like(covariances)
    roots[:, 0, 0], roots[:, 1, 1] = 1.0 / a, 1.0 / c
    roots[:, 1, 0] = -b / (a * c)
    return roots
