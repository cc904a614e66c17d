"""Thin edges: the points at which the gradient is largest along its own direction."""

from __future__ import annotations

from dataclasses import dataclass

import cv2
import numpy as np
from numba import njit
from numpy.typing import NDArray

from stereo_landmark.core.edges.gradient import gaussian_gradient
from stereo_landmark.core.edges.settings import EdgeSettings
from stereo_landmark.core.grey_image import check_grey_image


@dataclass(frozen=True)
class Edges:
    """The edge points of an image, row by row.

    Attributes:
        points: shape (n, 2), sub-pixel positions [px]; the centre of the first pixel is (0, 0).
        gradients: shape (n, 2), of the filtered image, towards the bright side [grey levels / px].
        index: shape (h, w), number of the edge point in each pixel, -1 where there is none.
    """

    points: NDArray[np.float64]
    gradients: NDArray[np.float64]
    index: NDArray[np.int32]

    def __len__(self) -> int:
        """Return the number of edge points."""
        return len(self.points)


def extract_edges(image: NDArray[np.uint8], settings: EdgeSettings) -> Edges:
    """Filter, binarise and thin (paper 3.3b): every point whose gradient reaches the continuation threshold.

    Args:
        image: shape (h, w), grey levels.
        settings: the image processing taught for the place.

    Raises:
        StereoLandmarkError: the image is of another type or shape, or too small.
    """
    check_grey_image(image)
    gx, gy = gaussian_gradient(image, settings.filter_sigma)
    strength = cv2.magnitude(gx, gy)
    index = np.full(image.shape, -1, np.int32)
    points, gradients = _thin(gx, gy, strength, settings.continuation * settings.threshold, index)
    return Edges(points, gradients, index)


@njit(cache=True, error_model='numpy')
def _thin(
    gx: NDArray[np.float32],
    gy: NDArray[np.float32],
    strength: NDArray[np.float32],
    threshold: float,
    index: NDArray[np.int32],
) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    # Maxima along the image axis that is nearer to the gradient: one point a row of a steep edge, one a
    # column of a flat one, so that following it never has to choose between two.
    height, width = gx.shape
    room = height * width // 4 + 16
    points, gradients = np.empty((room, 2)), np.empty((room, 2))
    count = 0
    for y in range(1, height - 1):
        for x in range(1, width - 1):
            here = strength[y, x]
            if here < threshold:
                continue
            across = abs(gx[y, x]) >= abs(gy[y, x])
            before = strength[y, x - 1] if across else strength[y - 1, x]
            after = strength[y, x + 1] if across else strength[y + 1, x]
            if here <= before or here < after or count == room:
                continue
            shift = _peak(before, here, after)
            points[count, 0] = x + shift if across else x
            points[count, 1] = y if across else y + shift
            gradients[count, 0], gradients[count, 1] = gx[y, x], gy[y, x]
            index[y, x] = count
            count += 1
    return points[:count].copy(), gradients[:count].copy()


@njit(cache=True, error_model='numpy')
def _peak(before: float, here: float, after: float) -> float:
    """Return the place of the maximum of the parabola through the logarithms; exact for a Gaussian profile."""
    low, mid, high = np.log(max(before, 1e-3)), np.log(here), np.log(max(after, 1e-3))
    bend = 2.0 * mid - low - high
    # Less than half a pixel, so that a point rounds to the pixel it was found in.
    return min(max(0.5 * (high - low) / bend, -0.499), 0.499) if bend > 0.0 else 0.0
