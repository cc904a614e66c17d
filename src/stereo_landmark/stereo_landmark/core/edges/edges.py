"""Subpixel edges of an image, by non-maximum suppression of the gradient magnitude, and their segments (paper 3.3b)."""

import math
from dataclasses import dataclass

import cv2
import numpy as np
from numba import njit
from numpy.typing import NDArray

from stereo_landmark.core.arrays import Floats, GreyImage, Masks
from stereo_landmark.core.edges.linking import extract_chains, index_points, link_points, polyline_vertices
from stereo_landmark.core.settings import EdgeSettings
from stereo_landmark.core.stereo_landmark_error import StereoLandmarkError


@njit(cache=True)
def thin(binary: Masks, passes: int) -> Masks:
    """Return a binary image thinned by at most so many passes, each of which peels one layer (Zhang & Suen 1984).

    Args:
        binary: mask of the pixels above the threshold, shape (h, w); its border is ignored.
        passes: number of passes; lines up to twice as wide become one pixel wide.
    """
    mask = binary.copy()
    mask[0], mask[-1], mask[:, 0], mask[:, -1] = False, False, False, False
    for _ in range(passes):
        removed = 0
        for side in range(2):
            peeled = np.zeros_like(mask)
            for y in range(1, mask.shape[0] - 1):
                for x in range(1, mask.shape[1] - 1):
                    peeled[y, x] = mask[y, x] and _is_removable(mask, x, y, side)
            mask &= ~peeled
            removed += int(np.sum(peeled))
        if removed == 0:
            break
    return mask


@njit(cache=True)
def _is_removable(mask: Masks, x: int, y: int, side: int) -> bool:
    """Return whether a pixel is at the lower right (side 0) or upper left edge of a line that stays connected."""
    up, right, down, left = mask[y - 1, x], mask[y, x + 1], mask[y + 1, x], mask[y, x - 1]
    around = (up, mask[y - 1, x + 1], right, mask[y + 1, x + 1], down, mask[y + 1, x - 1], left, mask[y - 1, x - 1])
    count, starts = 0, 0
    for k in range(8):
        count += around[k]
        starts += around[(k + 1) % 8] and not around[k]
    if not (2 <= count <= 6 and starts == 1):
        return False
    if side == 0:
        return not (up and right and down) and not (right and down and left)
    return not (up and right and left) and not (up and down and left)


SIDE_MIN = 16
"""Minimum image width and height [px]."""


def check_grey_image(image: GreyImage) -> None:
    """Check that an image is grey, 8 bit and large enough.

    Raises:
        StereoLandmarkError: wrong type, shape or size; one line that names both it and the expected one.
    """
    if not isinstance(image, np.ndarray) or image.dtype != np.uint8:
        kind = f'{image.dtype} values' if isinstance(image, np.ndarray) else type(image).__name__
        raise StereoLandmarkError(f'the image holds {kind}, it must be an array of uint8 (mono8)')
    if image.ndim != 2:
        raise StereoLandmarkError(f'the image has the shape {image.shape}, it must be grey, (h, w) (mono8)')
    if min(image.shape) < SIDE_MIN:
        raise StereoLandmarkError(
            f'the image is {image.shape[1]} x {image.shape[0]} px, each side must be at least {SIDE_MIN} px'
        )


def gaussian_gradient(image: GreyImage, sigma: float) -> tuple[NDArray[np.float32], NDArray[np.float32]]:
    """Return the derivatives along x and y of the smoothed image, each shape (h, w) [grey levels / px].

    Args:
        image: grey image, shape (h, w).
        sigma: standard deviation of the Gaussian [px].
    """
    radius = math.ceil(3.0 * sigma)
    offsets = np.arange(-radius, radius + 1, dtype=np.float64)
    gaussian = np.exp(-0.5 * (offsets / sigma) ** 2)
    gaussian /= gaussian.sum()
    derivative = offsets * gaussian
    derivative /= np.sum(offsets * derivative)  # a ramp of one grey level per pixel has gradient 1
    border = cv2.BORDER_REPLICATE
    gx = cv2.sepFilter2D(image, cv2.CV_32F, derivative, gaussian, borderType=border)
    gy = cv2.sepFilter2D(image, cv2.CV_32F, gaussian, derivative, borderType=border)
    return gx, gy


@dataclass(frozen=True)
class Edges:
    """The edge points of an image, row by row.

    Attributes:
        points: subpixel positions, shape (n, 2) [px]; the centre of the first pixel is (0, 0).
        gradients: image gradients, which point to the bright side, shape (n, 2) [grey levels / px].
        index: index of the edge point in each pixel, -1 where there is none, shape (h, w).
    """

    points: Floats
    gradients: Floats
    index: NDArray[np.int32]


def extract_edges(image: GreyImage, settings: EdgeSettings, region: Masks | None = None) -> Edges:
    """Detect edges (paper 3.3b: filter, binarise, thin) down to the lower hysteresis threshold.

    Args:
        image: grey image, shape (h, w).
        settings: edge detection settings that were taught for the place.
        region: mask of the pixels to consider, shape (h, w); None for all.

    Raises:
        StereoLandmarkError: the image has the wrong type or shape, or is too small.
    """
    check_grey_image(image)
    # Filter.
    gx, gy = gaussian_gradient(image, settings.filter_sigma)
    magnitude = cv2.magnitude(gx, gy)
    threshold = np.float32(settings.continuation * settings.threshold)
    if settings.thinning > 0.0:
        # The paper's steps: binarise, then thin.
        is_edge = thin(magnitude >= threshold, round(settings.thinning))
    else:
        # Both in one step: maxima of the gradient magnitude above the threshold are one pixel wide.
        is_edge = _suppress_non_maxima(gx, gy, magnitude, threshold)
    if region is not None:
        is_edge &= region
    index = np.full(image.shape, -1, np.int32)
    points, gradients, neighbour_ratios = _collect_points(gx, gy, magnitude, is_edge, index)
    # Subpixel positions (not in the paper); numpy vectorizes the logarithm, numba kernels do not.
    _refine_subpixel(points, gradients, np.log(neighbour_ratios))
    return Edges(points, gradients, index)


@dataclass(frozen=True)
class Segments:
    """The segments of an image, concatenated; the bright side is on the right of each.

    Attributes:
        points: subpixel edge points of all segments, shape (n, 2) [px].
        gradients: image gradients, which point to the bright side, shape (n, 2) [grey levels / px].
        starts: start of each segment in ``points``, shape (m + 1,).
        closed: whether the segment returns to its first point, shape (m,).
        vertex_indices: indices of the polyline vertices in ``points``, ends included, shape (k,).
        vertex_starts: start of each segment in ``vertex_indices``, shape (m + 1,).
        index: index in ``points`` of the edge in each pixel, -1 where there is none, shape (h, w).
    """

    points: Floats
    gradients: Floats
    starts: NDArray[np.int32]
    closed: Masks
    vertex_indices: NDArray[np.int32]
    vertex_starts: NDArray[np.int32]
    index: NDArray[np.int32]

    def __len__(self) -> int:
        return len(self.closed)


def trace_segments(edges: Edges, settings: EdgeSettings) -> Segments:
    """Link edges to segments and remove weak and short ones (paper 3.3b, 3.4)."""
    # Line following (3.4).
    successors = link_points(edges.points, edges.gradients, edges.index)
    # Noise removal (3.3b).
    magnitudes = np.sqrt(np.einsum('ij,ij->i', edges.gradients, edges.gradients))
    count_min = max(2, round(settings.length_min))
    order, starts, closed = extract_chains(successors, magnitudes, settings.threshold, count_min)
    points = edges.points.take(order, axis=0)
    # Sampled points on each segment that its polyline needs (3.4).
    vertex_indices, vertex_starts = polyline_vertices(points, starts, settings.bend_tolerance)
    index = index_points(points, edges.index.shape)
    return Segments(
        *(points, edges.gradients.take(order, axis=0), starts, closed, vertex_indices, vertex_starts), index=index
    )


@njit(cache=True, error_model='numpy')
def _suppress_non_maxima(
    gx: NDArray[np.float32], gy: NDArray[np.float32], magnitude: NDArray[np.float32], threshold: np.float32
) -> Masks:
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
            is_maximum[y, x] = (here >= threshold) & ((is_horizontal & in_row) | ((not is_horizontal) & in_column))
    return is_maximum


@njit(cache=True, error_model='numpy')
def _collect_points(
    gx: NDArray[np.float32],
    gy: NDArray[np.float32],
    magnitude: NDArray[np.float32],
    is_maximum: Masks,
    index: NDArray[np.int32],
) -> tuple[Floats, Floats, Floats]:
    """Return pixels, gradients and the relative gradient magnitudes of both neighbours of the maxima.

    Writes the point indices into ``index``.
    """
    height, width = gx.shape
    capacity = int(np.sum(is_maximum))
    points, gradients, neighbour_ratios = (np.empty((capacity, 2)), np.empty((capacity, 2)), np.empty((capacity, 2)))
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
def _refine_subpixel(points: Floats, gradients: Floats, log_ratios: Floats) -> None:
    """Move points to the maxima of parabolas through the log magnitudes; exact for a Gaussian profile."""
    for i in range(len(points)):
        low, high = log_ratios[i, 0], log_ratios[i, 1]
        curvature = -low - high
        # Less than half a pixel, so that a point rounds to the pixel in which it was detected.
        shift = min(max(0.5 * (high - low) / curvature, -0.499), 0.499) if curvature > 0.0 else 0.0
        points[i, 0 if abs(gradients[i, 0]) >= abs(gradients[i, 1]) else 1] += shift
