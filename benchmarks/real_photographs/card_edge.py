"""Where the upper face of a thick card ends, when its side may be seen below: a model of two blurred steps."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray
from scipy.optimize import least_squares
from scipy.special import ndtr

Array = NDArray[np.float64]

USUAL_BLUR = 0.78  # standard deviation of the camera's blur [px], seen at clean edges
BLUR_SPREAD = 0.08  # [px]
LEAST_CONTRAST = 0.3  # of a profile that is used, relative to the card's brightness
TOLERANCE = 0.05  # of brightness, relative to the step, above which a sample counts as an outlier
STARTS = ((-1.0, 1.5), (0.0, 0.5))  # first guesses of the edge and of the side's width [px]
SLOPE_OF_WIDTH = 0.5  # greatest, from one end of the edge to the other [px]


def fit_card_edge(profiles: Array, depth: Array) -> tuple[float, float] | None:
    """Return how far the edge of the face is beyond depth 0 at the edge's start and end [px].

    Brightness falls from the face to the side at the edge, and from the side to the ground a width further. The side
    may have no width. Edge and width are linear along the edge.

    Args:
        profiles: shape (n, m), brightness across the edge, at n places evenly spaced from its start to its end.
        depth: shape (m,), of the samples, outwards [px].

    Returns:
        None where fewer than three profiles have an edge.
    """
    inside = np.median(profiles[:, depth < -2.0], axis=1)
    beyond = depth > 0.5
    darkest = profiles[:, beyond].argmin(axis=1) + int(np.argmax(beyond))
    outside = np.take_along_axis(profiles, darkest[:, None], axis=1)[:, 0]
    usable = np.nonzero(inside - outside > LEAST_CONTRAST * inside)[0]
    if len(usable) < 3:
        return None
    share = (usable + 0.5) / len(profiles)
    level = (profiles[usable] - outside[usable, None]) / (inside - outside)[usable, None]
    weight = (depth[None] <= depth[darkest[usable], None] + 0.25).astype(np.float64)

    def residuals(state: Array) -> Array:
        first, last, width, slope, step, blur = state
        edge = first + (last - first) * share[:, None]
        lower = edge + np.maximum(width + slope * (share[:, None] - 0.5), 0.0)
        model = 1.0 - step * ndtr((depth - edge) / blur) - (1.0 - step) * ndtr((depth - lower) / blur)
        fit = (weight * (model - level)).ravel() / TOLERANCE
        return np.append(fit, np.sqrt(fit.size) * (blur - USUAL_BLUR) / BLUR_SPREAD / 4.0)

    lowest = [-3.0, -3.0, 0.0, -SLOPE_OF_WIDTH, 0.15, 0.4]
    highest = [3.0, 3.0, 7.0, SLOPE_OF_WIDTH, 1.0, 2.0]
    fits = [
        least_squares(
            residuals,
            [edge, edge, width, 0.0, 0.4, USUAL_BLUR],
            bounds=(lowest, highest),
            loss='soft_l1',
            xtol=1e-4,
        )
        for edge, width in STARTS
    ]
    best = min(fits, key=lambda fit: fit.cost)
    return float(best.x[0]), float(best.x[1])
