"""The paper's closed form (3.1): dx, dy, dz and theta_z between the taught and the current pose.

The paper's equation maps taught points to current ones, ``x = Rz(-theta_z) x_t + d``. The robot's pose in the taught
frame is the inverse: its yaw is ``+theta_z`` and its position ``-Rz(theta_z) d``.
"""

from __future__ import annotations

import cmath
from dataclasses import dataclass

import numpy as np

from shirube_core.geometry import SE2, wrap_angle
from stereo_landmark.core.arrays import Floats
from stereo_landmark.core.stereo import SpatialPoints

SPREAD_MIN = 0.005
"""Minimum horizontal RMS distance of the points from their mean; below it the yaw is not observable [m]."""
_STEP = 1e-6


@dataclass(frozen=True)
class Displacement:
    """The displacement parameters of the paper (section 3.1).

    Attributes:
        dx: translation along x from the rotated taught points to the current ones [m].
        dy: translation along y [m].
        dz: translation along z [m].
        theta_z: yaw of the robot relative to the taught pose, counter-clockwise [rad].
    """

    dx: float
    dy: float
    dz: float
    theta_z: float

    def apply(self, taught: Floats) -> Floats:
        """Transform taught points into the current frame, both of shape (n, 3) [m] (the paper's equation)."""
        cos, sin = np.cos(self.theta_z), np.sin(self.theta_z)
        turn = np.array([[cos, sin, 0.0], [-sin, cos, 0.0], [0.0, 0.0, 1.0]])
        return np.asarray(taught @ turn.T + [self.dx, self.dy, self.dz])

    @property
    def pose(self) -> SE2:
        """``T_place_base``: pose of the robot in the taught frame."""
        place = -cmath.rect(1.0, self.theta_z) * complex(self.dx, self.dy)
        return SE2(place.real, place.imag, self.theta_z)

    @property
    def height(self) -> float:
        """Height of the robot above the taught pose [m]."""
        return -self.dz

    @property
    def state(self) -> Floats:
        """x, y, z [m] and yaw [rad] of the robot in the taught frame, shape (4,)."""
        pose = self.pose
        return np.array([pose.x, pose.y, self.height, pose.yaw])


def closed_form(found: Floats, taught: Floats) -> Displacement | None:
    """Return the least-squares displacement from taught to current points.

    Args:
        found: current points in the gravity-aligned base frame, shape (n, 3) [m].
        taught: the same points as taught, shape (n, 3) [m].

    Returns:
        None for fewer than two points, or for points on one vertical line, which leave the yaw unobservable.
    """
    if len(found) < 2:
        return None
    mean, taught_mean = found.mean(axis=0), taught.mean(axis=0)
    here = (found - mean)[:, :2] @ np.array([1.0, 1.0j])
    there = (taught - taught_mean)[:, :2] @ np.array([1.0, 1.0j])
    if float(np.mean(np.abs(there) ** 2)) < SPREAD_MIN**2:
        return None
    turn = -cmath.phase(complex(np.sum(here * there.conj())))
    shift = complex(mean[0], mean[1]) - cmath.rect(1.0, -turn) * complex(*taught_mean[:2])
    return Displacement(shift.real, shift.imag, float(mean[2] - taught_mean[2]), turn)


def closed_form_covariance(found: SpatialPoints, taught: SpatialPoints) -> Floats:
    """Propagate the noise of the points to the covariance of the closed-form displacement.

    Args:
        found: current points in the gravity-aligned base frame, for which the closed form exists.
        taught: the same points as taught, in the same order.

    Returns:
        covariance of x, y, z [m] and yaw [rad] of the robot in the taught frame, shape (4, 4).
    """
    covariance = np.zeros((4, 4))
    for points, perturb_found in ((found, True), (taught, False)):
        for i in range(len(points)):
            columns = [
                _jacobian_column(found.positions, taught.positions, i, axis, perturb_found)
                for axis in range(3)
            ]
            jacobian = np.column_stack(columns)
            covariance += jacobian @ points.covariances[i] @ jacobian.T
    return covariance


def _jacobian_column(found: Floats, taught: Floats, i: int, axis: int, perturb_found: bool) -> Floats:
    """Return the numerical derivatives of x, y, z and yaw by one coordinate of a point, shape (4,)."""
    states = []
    for step in (-_STEP, _STEP):
        here, there = found.copy(), taught.copy()
        (here if perturb_found else there)[i, axis] += step
        displacement = closed_form(here, there)
        if displacement is None:
            return np.full(4, np.inf)
        states.append(displacement.state)
    change = states[1] - states[0]
    change[3] = wrap_angle(float(change[3]))
    return np.asarray(change / (2.0 * _STEP))
