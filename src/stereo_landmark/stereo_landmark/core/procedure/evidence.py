"""How much speaks for a supposed pose: what should be in view there is, and chance would not have put it there."""

from __future__ import annotations

import math
from collections.abc import Sequence

import numpy as np
from numba import njit
from numpy.typing import NDArray

from stereo_landmark.core.procedure.prediction import expected_pixels
from stereo_landmark.core.procedure.primitive import Tolerances
from stereo_landmark.core.procedure.settings import SearchSettings
from stereo_landmark.core.procedure.stereo_candidates import alike_primitives
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
        self._positions = np.array([primitive.position for primitive in expected]).reshape(-1, 3)
        self._view = view
        alike = alike_primitives(expected, view.left.kinds, tolerances)
        counts = [int(row.sum()) for row in alike]
        self._starts = np.cumsum([0, *counts])
        centres = [view.left.kinds[each.kind].centres[row] for each, row in zip(expected, alike, strict=True)]
        self._centres = np.concatenate([np.empty((0, 2)), *centres])
        self._chances = np.array([self._chance(primitive) for primitive in expected])
        self._sure = settings.found_probability

    def weigh(self, states: NDArray[np.float64]) -> NDArray[np.float64]:
        """Return the log likelihoods of poses above that of chance, shape (h,).

        Args:
            states: shape (h, 4), x, y, z [m] and yaw [rad] in the place's frame.
        """
        pixels = expected_pixels(states, self._positions, self._view)
        near = np.exp(-0.5 * _squares_to_found(pixels, self._starts, self._centres) / SPREAD**2)
        speaks = np.log(self._sure * near / self._chances + 1.0 - self._sure)
        return np.asarray(np.sum(np.where(self._in_view(pixels), speaks, 0.0), axis=1))

    def _in_view(self, pixels: NDArray[np.float64]) -> NDArray[np.bool_]:
        width, height = self._view.rig.left.width, self._view.rig.left.height
        u, v = pixels[..., 0], pixels[..., 1]
        return (u > BORDER) & (u < width - 1 - BORDER) & (v > BORDER) & (v < height - 1 - BORDER)

    def _chance(self, primitive: TaughtPrimitive) -> float:
        """Return how likely a window anywhere holds a primitive of the kind."""
        area = self._view.rig.left.width * self._view.rig.left.height
        count = len(self._view.left.kinds[primitive.kind].primitives)
        return min(max(count * math.pi * WINDOW**2 / area, CHANCE_MIN), CHANCE_MAX)


@njit(cache=True)
def _squares_to_found(
    pixels: NDArray[np.float64], starts: NDArray[np.int64], centres: NDArray[np.float64]
) -> NDArray[np.float64]:
    """Return the squared ways to the nearest primitives like expected ones, infinite outside of the window, (h, k).

    Args:
        pixels: shape (h, k, 4), where they are expected.
        starts: shape (k + 1,), where the centres of what looks like each begin.
        centres: shape (n, 2) [px].
    """
    squares = np.full(pixels.shape[:2], np.inf)
    for h in range(pixels.shape[0]):
        for k in range(pixels.shape[1]):
            u, v = pixels[h, k, 0], pixels[h, k, 1]
            for i in range(starts[k], starts[k + 1]):
                square = (centres[i, 0] - u) ** 2 + (centres[i, 1] - v) ** 2
                if square <= WINDOW**2 and square < squares[h, k]:
                    squares[h, k] = square
    return squares
