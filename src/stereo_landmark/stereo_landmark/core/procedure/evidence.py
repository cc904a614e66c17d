"""How much speaks for a supposed pose: what should be in view there is, and chance would not have put it there."""

from __future__ import annotations

import math
from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from stereo_landmark.core.procedure.prediction import expected_pixels
from stereo_landmark.core.procedure.primitive import Tolerances, difference
from stereo_landmark.core.procedure.settings import SearchSettings
from stereo_landmark.core.procedure.stereo_view import StereoView
from stereo_landmark.core.procedure.taught_place import TaughtPrimitive

WINDOW = 5.0
"""A primitive counts as found this near to where it is expected from a fitted pose [px]."""
SPREAD = 1.0
"""Standard deviation of where it is found, along each axis [px]; rows of other spacing are told apart by it. Rendered
scenes show 0.01 px for what the pose was fitted to and 0.1 px for things around; calibrations are worse."""
BORDER = 8.0
"""What is expected nearer to the border may be out of view [px]."""
CHANCE_MIN, CHANCE_MAX = 0.05, 0.5
"""That a window holds a primitive anyhow; walls have patterns, so chance is never as small as if they had none."""


class Evidence:
    """Weighs poses against the primitives of one image.

    Args:
        expected: taught primitives, of the targets and around them.
        view: both images.
        tolerances: how far primitives may differ.
        settings: how likely a primitive is found.
    """

    def __init__(
        self,
        expected: Sequence[TaughtPrimitive],
        view: StereoView,
        tolerances: Tolerances,
        settings: SearchSettings,
    ) -> None:
        self._expected = expected
        self._positions = np.array([primitive.position for primitive in expected]).reshape(-1, 3)
        self._view = view
        self._tolerances = tolerances
        self._settings = settings
        self._alike: dict[tuple[int, int], bool] = {}
        self._chances = np.array([self._chance(primitive) for primitive in expected])

    def weigh(self, state: NDArray[np.float64]) -> float:
        """Return the log likelihood of a pose above that of chance.

        Args:
            state: shape (4,), x, y, z [m] and yaw [rad] in the place's frame.
        """
        pixels = expected_pixels(state[None], self._positions, self._view)[0]
        total = 0.0
        for k in np.flatnonzero(self._in_view(pixels)):
            chance = self._chances[k]
            sure = self._settings.found_probability
            near = math.exp(-0.5 * (self._way_to_found(int(k), pixels[k, :2]) / SPREAD) ** 2)
            total += math.log(sure * near / chance + 1.0 - sure)
        return total

    def _in_view(self, pixels: NDArray[np.float64]) -> NDArray[np.bool_]:
        width, height = self._view.rig.left.width, self._view.rig.left.height
        u, v = pixels[:, 0], pixels[:, 1]
        return (u > BORDER) & (u < width - 1 - BORDER) & (v > BORDER) & (v < height - 1 - BORDER)

    def _way_to_found(self, k: int, place: NDArray[np.float64]) -> float:
        """Return how far the nearest primitive like an expected one is, infinite outside of its window [px]."""
        among = self._view.left.kinds[self._expected[k].kind]
        if not among.primitives:
            return math.inf
        ways = np.hypot(*(among.centres - place).T)
        near = np.flatnonzero(ways <= WINDOW)
        for i in near[np.argsort(ways[near])].tolist():
            if self._is_alike(k, i):
                return float(ways[i])
        return math.inf

    def _is_alike(self, k: int, i: int) -> bool:
        if (k, i) not in self._alike:
            found = self._view.left.kinds[self._expected[k].kind].primitives[i]
            self._alike[k, i] = difference(found, self._expected[k].shape, self._tolerances) <= 1.0
        return self._alike[k, i]

    def _chance(self, primitive: TaughtPrimitive) -> float:
        """Return how likely a window anywhere holds a primitive of the kind."""
        area = self._view.rig.left.width * self._view.rig.left.height
        count = len(self._view.left.kinds[primitive.kind].primitives)
        return min(max(count * math.pi * WINDOW**2 / area, CHANCE_MIN), CHANCE_MAX)
