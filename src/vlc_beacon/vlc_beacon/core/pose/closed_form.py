"""Closed-form poses from two lamps, without an initial guess.

With complex numbers for the plane, a lamp X at height Z that is observed along the slopes s in the level frame obeys
``X = P + k (A - z B)`` with the robot's position P, heading ``k = exp(i yaw)``, height z,
``A = d + e (t + (Z - t_z) s)`` and ``B = e s``, where t is the camera in the level frame, and d and ``e = exp(i turn)``
are the robot's motion until the observation. Two lamps give ``X1 - X2 = k (D - z E)``: the lengths give z (a quadratic
equation), the directions k.
"""

import cmath
import math

import numpy as np
from numpy.typing import NDArray

from shirube_core.geometry import SE3
from vlc_beacon.core.pose.bearing_model import STATES
from vlc_beacon.core.pose.lamp_rays import LampRays

SLOPE_MAX = 20.0
"""Maximum slope; lamps within 3 degrees of the horizon do not determine the height."""


class TwoLampSolver:
    """The lamps of one image as complex numbers."""

    def __init__(
        self, rays: LampRays, lamps: NDArray[np.float64], camera: SE3, known_height: float | None = None
    ) -> None:
        """Set the observations; arguments as in `PoseLeastSquares`."""
        self._known_height = known_height
        self._positions = lamps[:, 0] + 1j * lamps[:, 1]
        directions = np.column_stack([rays.rays, np.ones(len(rays))]) @ camera.rotation.T
        upward = directions[:, 2]
        flat = np.hypot(directions[:, 0], directions[:, 1])
        self._usable = np.abs(upward) * SLOPE_MAX > flat
        slopes = (directions[:, 0] + 1j * directions[:, 1]) / np.where(self._usable, upward, 1.0)
        turns = np.exp(1j * rays.motions[:, 2])
        camera_offset = complex(camera.position[0], camera.position[1])
        height_offset = lamps[:, 2] - camera.position[2]
        self._A = rays.motions[:, 0] + 1j * rays.motions[:, 1] + turns * (camera_offset + height_offset * slopes)
        self._B = turns * slopes

    def widest_pairs(self, count: int) -> list[tuple[int, int]]:
        """Return up to ``count`` pairs of different lamps, those with the largest separation first."""
        first, second = np.triu_indices(len(self._B), 1)
        valid = self._usable[first] & self._usable[second] & (self._positions[first] != self._positions[second])
        first, second = first[valid], second[valid]
        order = np.argsort(-np.abs(self._B[first] - self._B[second]), kind='stable')[:count]
        return [(int(first[k]), int(second[k])) for k in order]

    def solve_pair(self, i: int, j: int) -> list[NDArray[np.float64]]:
        """Return the states consistent with two lamps, each of shape (6,); none, one or two."""
        baseline = complex(self._positions[i] - self._positions[j])
        D, E = complex(self._A[i] - self._A[j]), complex(self._B[i] - self._B[j])
        if abs(E) < 1e-9:
            return []
        states = []
        for z in self._heights(baseline, D, E):
            seen = D - z * E
            if abs(seen) > 0.0:
                k = baseline / seen
                states.append(self._state(k / abs(k), z, [i, j]))
        return states

    def _heights(self, baseline: complex, D: complex, E: complex) -> list[float]:
        if self._known_height is not None:
            return [self._known_height]
        middle = (D * E.conjugate()).real / abs(E) ** 2
        # Noise can make the discriminant negative where both solutions coincide.
        squared = middle**2 - (abs(D) ** 2 - abs(baseline) ** 2) / abs(E) ** 2
        height_offset = math.sqrt(max(squared, 0.0))
        return [middle - height_offset, middle + height_offset] if height_offset > 0.0 else [middle]

    def _state(self, k: complex, z: float, indices: list[int]) -> NDArray[np.float64]:
        position = complex(np.mean(self._positions[indices] - k * (self._A[indices] - z * self._B[indices])))
        state = np.zeros(STATES)
        state[:4] = position.real, position.imag, z, cmath.phase(k)
        return state
