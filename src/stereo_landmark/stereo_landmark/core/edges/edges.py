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
    strength = cv2.magnitude(gx, gy)
    marked = _mark_maxima(gx, gy, strength, np.float32(settings.continuation * settings.threshold))
    index = np.full(image.shape, -1, np.int32)
    points, gradients, beside = _gather(gx, gy, strength, marked, index)
    # numpy vectorizes the logarithm, numba kernels do not.
    _move_to_peaks(points, gradients, np.log(beside))
    return Edges(points, gradients, index)


@njit(cache=True, error_model='numpy')
def _mark_maxima(
    gx: NDArray[np.float32], gy: NDArray[np.float32], strength: NDArray[np.float32], threshold: np.float32
) -> NDArray[np.bool_]:
    # Maxima along the image axis nearest to the gradient: one point per row of a steep edge, one per
    # column of a flat edge, so that edge linking never has two candidates in a row or column.
    height, width = gx.shape
    marked = np.zeros((height, width), np.bool_)
    for y in range(1, height - 1):
        for x in range(1, width - 1):
            # No branches, so that the compiler can vectorize the loop.
            here = strength[y, x]
            in_row = (here > strength[y, x - 1]) & (here >= strength[y, x + 1])
            in_column = (here > strength[y - 1, x]) & (here >= strength[y + 1, x])
            across = abs(gx[y, x]) >= abs(gy[y, x])
            marked[y, x] = (here >= threshold) & ((across & in_row) | ((not across) & in_column))
    return marked


@njit(cache=True, error_model='numpy')
def _gather(
    gx: NDArray[np.float32],
    gy: NDArray[np.float32],
    strength: NDArray[np.float32],
    marked: NDArray[np.bool_],
    index: NDArray[np.int32],
) -> tuple[NDArray[np.float64], NDArray[np.float64], NDArray[np.float64]]:
    """Return pixels, gradients and the relative gradient magnitudes of both neighbours of the maxima.

    Writes the point indices into ``index``.
    """
    height, width = gx.shape
    room = int(np.sum(marked))
    points, gradients, beside = np.empty((room, 2)), np.empty((room, 2)), np.empty((room, 2))
    count = 0
    for y in range(1, height - 1):
        for x in range(1, width - 1):
            if not marked[y, x]:
                continue
            across = abs(gx[y, x]) >= abs(gy[y, x])
            before = strength[y, x - 1] if across else strength[y - 1, x]
            after = strength[y, x + 1] if across else strength[y + 1, x]
            points[count, 0], points[count, 1] = x, y
            gradients[count, 0], gradients[count, 1] = gx[y, x], gy[y, x]
            beside[count, 0] = max(before, 1e-3) / strength[y, x]
            beside[count, 1] = max(after, 1e-3) / strength[y, x]
            index[y, x] = count
            count += 1
    return points, gradients, beside


@njit(cache=True, error_model='numpy')
def _move_to_peaks(
    points: NDArray[np.float64], gradients: NDArray[np.float64], logarithms: NDArray[np.float64]
) -> None:
    """Move points to the maxima of parabolas through the log magnitudes; exact for a Gaussian profile."""
    for i in range(len(points)):
        low, high = logarithms[i, 0], logarithms[i, 1]
        bend = -low - high
        # Less than half a pixel, so that a point rounds to the pixel in which it was detected.
        shift = min(max(0.5 * (high - low) / bend, -0.499), 0.499) if bend > 0.0 else 0.0
        points[i, 0 if abs(gradients[i, 0]) >= abs(gradients[i, 1]) else 1] += shift
