"""Log-likelihood ratio of a pose hypothesis: expected primitives are detected, against detections by chance."""

from __future__ import annotations

import math
from collections.abc import Sequence

import numpy as np
from numba import njit

from stereo_landmark.core.arrays import Floats, Ints, Masks
from stereo_landmark.core.primitives.primitive import Tolerances
from stereo_landmark.core.procedure.guided_matching import similar_primitives
from stereo_landmark.core.procedure.prediction import predict_pixels
from stereo_landmark.core.procedure.stereo_view import StereoView
from stereo_landmark.core.procedure.taught_place import TaughtPrimitive
from stereo_landmark.core.settings import SearchSettings

WINDOW = 5.0
"""Maximum distance of a detection from its predicted pixel [px]."""
CENTRE_SIGMA = 1.0
"""Standard deviation of a detection along each axis [px]; it separates rows of different spacing. Rendered scenes show
0.01 px for the fitted primitives and 0.1 px for the context landmarks; real calibrations are worse."""
BORDER_MARGIN = 8.0
"""Primitives predicted nearer to the border may be out of view [px]."""
FALSE_POSITIVE_MIN, FALSE_POSITIVE_MAX = 0.05, 0.5
"""Limits of the probability of a false positive in a window; patterns on walls keep it above the lower limit."""


class PoseScorer:
    """Scores pose hypotheses by the primitives of the left image.

    Args:
        expected: taught primitives: those of the targets and the context landmarks.
        view: stereo view.
        tolerances: tolerances of the shape comparison.
        settings: search settings with the detection probability.
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
        similar = similar_primitives(expected, view.left.kinds, tolerances)
        similar_counts = [int(row.sum()) for row in similar]
        self._starts = np.cumsum([0, *similar_counts])
        centres = [
            view.left.kinds[each.kind].centres[row] for each, row in zip(expected, similar, strict=True)
        ]
        self._centres = np.concatenate([np.empty((0, 2)), *centres])
        self._false_positives = np.array(
            [self._false_positive_probability(primitive) for primitive in expected]
        )
        self._detection_probability = settings.detection_probability

    def score(self, states: Floats) -> Floats:
        """Return the log-likelihood ratios of poses against chance, shape (h,).

        Args:
            states: x, y, z [m] and yaw [rad] in the place's frame, shape (h, 4).
        """
        pixels = predict_pixels(states, self._positions, self._view)
        near = np.exp(-0.5 * _squared_distances(pixels, self._starts, self._centres) / CENTRE_SIGMA**2)
        log_ratios = np.log(
            self._detection_probability * near / self._false_positives + 1.0 - self._detection_probability
        )
        return np.asarray(np.sum(np.where(self._is_in_view(pixels), log_ratios, 0.0), axis=1))

    def _is_in_view(self, pixels: Floats) -> Masks:
        width, height = self._view.rig.left.width, self._view.rig.left.height
        u, v = pixels[..., 0], pixels[..., 1]
        return (
            (u > BORDER_MARGIN)
            & (u < width - 1 - BORDER_MARGIN)
            & (v > BORDER_MARGIN)
            & (v < height - 1 - BORDER_MARGIN)
        )

    def _false_positive_probability(self, primitive: TaughtPrimitive) -> float:
        """Return the probability that a window contains a primitive of this kind by chance."""
        area = self._view.rig.left.width * self._view.rig.left.height
        count = len(self._view.left.kinds[primitive.kind].primitives)
        return min(max(count * math.pi * WINDOW**2 / area, FALSE_POSITIVE_MIN), FALSE_POSITIVE_MAX)


@njit(cache=True)
def _squared_distances(pixels: Floats, starts: Ints, centres: Floats) -> Floats:
    """Return squared distances to the nearest similar primitives, infinite outside of the window, shape (h, k) [px²].

    Predicted pixels have the shape (h, k, 4), centres the shape (n, 2), with ``starts`` of each primitive, (k + 1,).
    """
    squared_distances = np.full(pixels.shape[:2], np.inf)
    for h in range(pixels.shape[0]):
        for k in range(pixels.shape[1]):
            u, v = pixels[h, k, 0], pixels[h, k, 1]
            for i in range(starts[k], starts[k + 1]):
                squared_distance = (centres[i, 0] - u) ** 2 + (centres[i, 1] - v) ** 2
                if squared_distance <= WINDOW**2 and squared_distance < squared_distances[h, k]:
                    squared_distances[h, k] = squared_distance
    return squared_distances
