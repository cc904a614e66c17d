"""Closed-form poses from two lamps, without an initial guess.

With complex numbers for the plane, a lamp X at height Z that is observed along the slopes s in the level frame obeys
``X = P + k (A - z B)`` with the robot's position P, heading ``k = exp(i yaw)``, height z,
``A = d + e (t + (Z - t_z) s)`` and ``B = e s``, where t is the camera in the level frame, and d and ``e = exp(i turn)``
are the robot's motion until the observation. Two lamps give ``X1 - X2 = k (D - z E)``: the lengths give z (a quadratic
equation), the directions k.
"""

from __future__ import annotations

import cmath
import math

import numpy as np
from numpy.typing import NDArray

from shirube_geometry import LevelCamera
from vlc_beacon.core.pose.bearing_model import STATES
from vlc_beacon.core.pose.known_states import KnownStates
from vlc_beacon.core.pose.lamp_rays import LampRays

SLOPE_MAX = 20.0
"""Maximum slope; lamps within 3 degrees of the horizon do not determine the height."""


class ClosedForm:
    """The lamps of one image as complex numbers."""

    def __init__(
        self, rays: LampRays, lamps: NDArray[np.float64], camera: LevelCamera, known: KnownStates
    ) -> None:
        """Set the observations.

        Args:
            rays: n observations.
            lamps: lamp positions in the map frame, shape (n, 3) [m].
            camera: gravity-aligned camera pose on the robot.
            known: known components of the pose.
        """
        self._known = known
        self._places = lamps[:, 0] + 1j * lamps[:, 1]
        directions = np.column_stack([rays.rays, np.ones(len(rays))]) @ camera.rotation.T
        upward = directions[:, 2]
        flat = np.hypot(directions[:, 0], directions[:, 1])
        self._usable = np.abs(upward) * SLOPE_MAX > flat
        slopes = (directions[:, 0] + 1j * directions[:, 1]) / np.where(self._usable, upward, 1.0)
        turns = np.exp(1j * rays.motions[:, 2])
        arm = complex(camera.position[0], camera.position[1])
        reach = lamps[:, 2] - camera.position[2]
        self._A = rays.motions[:, 0] + 1j * rays.motions[:, 1] + turns * (arm + reach * slopes)
        self._B = turns * slopes

    def widest_pairs(self, count: int) -> list[tuple[int, int]]:
        """Return up to ``count`` pairs of different lamps, those with the largest separation first."""
        first, second = np.triu_indices(len(self._B), 1)
        good = self._usable[first] & self._usable[second] & (self._places[first] != self._places[second])
        first, second = first[good], second[good]
        order = np.argsort(-np.abs(self._B[first] - self._B[second]), kind='stable')[:count]
        return [(int(first[k]), int(second[k])) for k in order]

    def states_of_pair(self, i: int, j: int) -> list[NDArray[np.float64]]:
        """Return the states consistent with two lamps, each of shape (6,); none, one or two."""
        way = complex(self._places[i] - self._places[j])
        D, E = complex(self._A[i] - self._A[j]), complex(self._B[i] - self._B[j])
        if abs(E) < 1e-9:
            return []
        states = []
        for z in self._heights(way, D, E):
            seen = D - z * E
            if abs(seen) > 0.0:
                k = way / seen
                states.append(self._state(k / abs(k), z, [i, j]))
        return states

    def _heights(self, way: complex, D: complex, E: complex) -> list[float]:
        if self._known.height is not None:
            return [self._known.height]
        middle = (D * E.conjugate()).real / abs(E) ** 2
        # Noise can make the discriminant negative where both solutions coincide.
        squared = middle**2 - (abs(D) ** 2 - abs(way) ** 2) / abs(E) ** 2
        reach = math.sqrt(max(squared, 0.0))
        return [middle - reach, middle + reach] if reach > 0.0 else [middle]

    def _state(self, k: complex, z: float, which: list[int]) -> NDArray[np.float64]:
        place = complex(np.mean(self._places[which] - k * (self._A[which] - z * self._B[which])))
        state = np.zeros(STATES)
        state[:4] = place.real, place.imag, z, cmath.phase(k)
        return state
