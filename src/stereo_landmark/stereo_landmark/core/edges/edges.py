"""Subpixel edge detection: non-maximum suppression of the gradient magnitude."""

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
        points: subpixel positions, shape (n, 2) [px]; the centre of the first pixel is (0, 0).
        gradients: image gradients, which point to the bright side, shape (n, 2) [grey levels / px].
        index: index of the edge point in each pixel, -1 where there is none, shape (h, w).
    """

    points: NDArray[np.float64]
    gradients: NDArray[np.float64]
    index: NDArray[np.int32]

    def __len__(self) -> int:
        """Return the number of edge points."""
        return len(self.points)


def extract_edges(image: NDArray[np.uint8], settings: EdgeSettings) -> Edges:
    """Detect edges (paper 3.3b: filter, binarise, thin) down to the lower hysteresis threshold.

    Args:
        image: grey image, shape (h, w).
        settings: edge detection settings that were taught for the place.

    Raises:
        StereoLandmarkError: the image has the wrong type or shape, or is too small.
    """
    check_grey_image(image)
    gx, gy = gaussian_gradient(image, settings.filter_sigma)
    magnitude = cv2.magnitude(gx, gy)
    is_maximum = _suppress_non_maxima(
        gx, gy, magnitude, np.float32(settings.continuation * settings.threshold)
    )
    index = np.full(image.shape, -1, np.int32)
    points, gradients, neighbour_ratios = _collect_points(gx, gy, magnitude, is_maximum, index)
    # numpy vectorizes the logarithm, numba kernels do not.
    _refine_subpixel(points, gradients, np.log(neighbour_ratios))
    return Edges(points, gradients, index)


@njit(cache=True, error_model='numpy')
def _suppress_non_maxima(
    gx: NDArray[np.float32], gy: NDArray[np.float32], magnitude: NDArray[np.float32], threshold: np.float32
) -> NDArray[np.bool_]:
    # Maxima along the image axis nearest to the gradient: one point per row of a steep edge, one per
    # column of a flat edge, so that edge linking never has two candidates in a row or column.
    height, width = gx.shape
    is_maximum = np.zeros((height, width), np.bool_)
    for y in range(1, height - 1):
        for x in range(1, width - 1):
            # No branches, so that the compiler can vectorize the loop.
            here = magnitude[y, x]
            in_row = (here > magnitude[y, x - 1]) & (here >= magnitude[y, x + 1])
            in_column = (here > magnitude[y - 1, x]) & (here >= magnitude[y + 1, x])
            is_horizontal = abs(gx[y, x]) >= abs(gy[y, x])
            is_maximum[y, x] = (here >= threshold) & (
                (is_horizontal & in_row) | ((not is_horizontal) & in_column)
            )
    return is_maximum


@njit(cache=True, error_model='numpy')
def _collect_points(
    gx: NDArray[np.float32],
    gy: NDArray[np.float32],
    magnitude: NDArray[np.float32],
    is_maximum: NDArray[np.bool_],
    index: NDArray[np.int32],
) -> tuple[NDArray[np.float64], NDArray[np.float64], NDArray[np.float64]]:
    """Return pixels, gradients and the relative gradient magnitudes of both neighbours of the maxima.

    Writes the point indices into ``index``.
    """
    height, width = gx.shape
    capacity = int(np.sum(is_maximum))
    points, gradients, neighbour_ratios = (
        np.empty((capacity, 2)),
        np.empty((capacity, 2)),
        np.empty((capacity, 2)),
    )
    count = 0
    for y in range(1, height - 1):
        for x in range(1, width - 1):
            if not is_maximum[y, x]:
                continue
            is_horizontal = abs(gx[y, x]) >= abs(gy[y, x])
            before = magnitude[y, x - 1] if is_horizontal else magnitude[y - 1, x]
            after = magnitude[y, x + 1] if is_horizontal else magnitude[y + 1, x]
            points[count, 0], points[count, 1] = x, y
            gradients[count, 0], gradients[count, 1] = gx[y, x], gy[y, x]
            neighbour_ratios[count, 0] = max(before, 1e-3) / magnitude[y, x]
            neighbour_ratios[count, 1] = max(after, 1e-3) / magnitude[y, x]
            index[y, x] = count
            count += 1
    return points, gradients, neighbour_ratios


@njit(cache=True, error_model='numpy')
def _refine_subpixel(
    points: NDArray[np.float64], gradients: NDArray[np.float64], log_ratios: NDArray[np.float64]
) -> None:
    """Move points to the maxima of parabolas through the log magnitudes; exact for a Gaussian profile."""
    for i in range(len(points)):
        low, high = log_ratios[i, 0], log_ratios[i, 1]
        curvature = -low - high
        # Less than half a pixel, so that a point rounds to the pixel in which it was detected.
        shift = min(max(0.5 * (high - low) / curvature, -0.499), 0.499) if curvature > 0.0 else 0.0
        points[i, 0 if abs(gradients[i, 0]) >= abs(gradients[i, 1]) else 1] += shift
