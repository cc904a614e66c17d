"""Splitting of touching dots: a blob with a waist is two."""

from __future__ import annotations

import numpy as np
from numba import njit
from numpy.typing import NDArray

from floor_localizer.core.dot_extraction.binarisation import contrast_image
from floor_localizer.core.dot_extraction.distance_basins import distance_basins
from floor_localizer.core.dot_extraction.labelling import Boxes, Labels, bounding_boxes

# A convex chip has no waist at all; ragged outlines of single chips have waists above this.
_LARGEST_WAIST = 0.88
# Area over the area of the ellipse of equal moments: 1 for an ellipse, 0.90 for two equal discs side by side,
# 0.83 for three; two discs are also at least 1.9 times as long as wide.
_ELLIPTIC = 0.98
_CLUSTERED = 0.88
_SHORT = 1.4
# Blobs of more area than this multiple of the median are looked at whatever their shape.
_LARGE = 1.6
# Contrast of the outline in which a waist is sought, as a part of the blob's: the higher, the deeper may blur
# fill the gap between two dots.
_OUTLINE = 0.67
# Blobs are looked at on a raster on which they are about this many pixels wide.
_RASTER = 22.0
# That outline cuts into small dots: a part may look thinner than the smallest dot by this ratio.
_THINNED = 0.7


def split_touching(
    labels: Labels,
    boxes: Boxes,
    image: NDArray[np.uint8],
    background: NDArray[np.float32],
    polarity: str,
    smallest_diameter: float,
) -> tuple[Boxes, NDArray[np.bool_]]:
    """Give the parts of blobs that consist of several dots labels of their own, in place.

    The outline is sought in the unsmoothed image: smoothing fills the gaps between dots.

    Args:
        labels: the blobs; pixels outside that outline of a split blob go back to the floor.
        boxes: their bounding boxes.
        image: shape (h, w, channels), grey levels, not smoothed.
        background: shape (h, w, channels), grey levels of the floor.
        polarity: ``dark``, ``light``, or ``any``.
        smallest_diameter: diameter of the smallest dot [px].

    Returns:
        the bounding boxes of the blobs and, after them, of the parts that were split off; and which of
        these are parts of a blob.
    """
    count = len(boxes)
    split = np.zeros(count, dtype=np.bool_)
    for i in _candidates(labels, boxes, 0.5 * np.pi * smallest_diameter**2):
        left, top, right, bottom, area = (int(number) for number in boxes[i])
        scale = min(4, max(1, round(_RASTER / area**0.5)))
        patch = labels[top:bottom, left:right]
        window = (slice(top, bottom), slice(left, right))
        contrast = contrast_image(image[window], background[window], polarity)
        raster = _outline_raster(patch, i + 1, contrast, scale)
        basins, parts = distance_basins(raster, _LARGEST_WAIST, 0.5 * _THINNED * scale * smallest_diameter)
        if parts > 1:
            _relabel(patch, i + 1, basins, scale, count)
            count += parts - 1
            split[i] = True
    if count == len(boxes):
        return boxes, split
    return bounding_boxes(labels, count), np.append(split, np.ones(count - len(boxes), dtype=np.bool_))


@njit(cache=True)
def _candidates(labels: Labels, boxes: Boxes, smallest_area: float) -> NDArray[np.int64]:
    found = np.empty(len(boxes), np.int64)
    count = 0
    areas = boxes[boxes[:, 4] >= 0.5 * smallest_area, 4]
    large = _LARGE * np.median(areas) if len(areas) > 0 else 0.0
    for i in range(len(boxes)):
        suspect = boxes[i, 4] > large or not _is_single(labels, boxes[i], i + 1)
        if boxes[i, 4] >= smallest_area and suspect:
            found[count] = i
            count += 1
    return found[:count]


@njit(cache=True)
def _is_single(labels: Labels, box: NDArray[np.int32], label: int) -> bool:
    n = su = sv = suu = suv = svv = 0.0
    for v in range(box[3] - box[1]):
        for u in range(box[2] - box[0]):
            if labels[box[1] + v, box[0] + u] == label:
                n += 1.0
                su += u
                sv += v
                suu += u * u
                suv += u * v
                svv += v * v
    uu = suu / n - (su / n) ** 2 + 1.0 / 12.0
    vv = svv / n - (sv / n) ** 2 + 1.0 / 12.0
    uv = suv / n - su * sv / n**2
    determinant = max(1e-12, uu * vv - uv * uv)
    ellipticity = n / (4.0 * np.pi * np.sqrt(determinant))
    half_trace = 0.5 * (uu + vv)
    elongation = (half_trace + np.sqrt(max(0.0, half_trace**2 - determinant))) / np.sqrt(determinant)
    return ellipticity > _ELLIPTIC or (ellipticity > _CLUSTERED and elongation < _SHORT)


@njit(cache=True)
def _outline_raster(
    labels: Labels, label: int, contrast: NDArray[np.float32], scale: int
) -> NDArray[np.uint8]:
    rows, columns = labels.shape
    inside = np.empty(labels.size, np.float32)
    count = 0
    for v in range(rows):
        for u in range(columns):
            if labels[v, u] == label:
                inside[count] = contrast[v, u]
                count += 1
            else:
                contrast[v, u] = 0.0
    level = _OUTLINE * np.median(inside[:count])
    # A frame of zeros keeps the flood from leaving the raster.
    raster = np.zeros((rows * scale + 2, columns * scale + 2), np.uint8)
    for row in range(rows * scale):
        y = (row + 0.5) / scale - 0.5
        for column in range(columns * scale):
            x = (column + 0.5) / scale - 0.5
            raster[row + 1, column + 1] = _interpolated(contrast, y, x) > level
    return raster


@njit(cache=True)
def _interpolated(values: NDArray[np.float32], y: float, x: float) -> float:
    y, x = min(max(y, 0.0), values.shape[0] - 1.0), min(max(x, 0.0), values.shape[1] - 1.0)
    v, u = int(y), int(x)
    lower, right = min(v + 1, values.shape[0] - 1), min(u + 1, values.shape[1] - 1)
    above = values[v, u] + (x - u) * (values[v, right] - values[v, u])
    below = values[lower, u] + (x - u) * (values[lower, right] - values[lower, u])
    return above + (y - v) * (below - above)


@njit(cache=True)
def _relabel(labels: Labels, label: int, basins: NDArray[np.int32], scale: int, count: int) -> None:
    # The first part keeps the blob's label; the others get the labels after the last one so far.
    for v in range(labels.shape[0]):
        for u in range(labels.shape[1]):
            if labels[v, u] == label:
                basin = basins[1 + v * scale + scale // 2, 1 + u * scale + scale // 2]
                if basin == 0:
                    labels[v, u] = 0
                elif basin > 1:
                    labels[v, u] = count + basin - 1
