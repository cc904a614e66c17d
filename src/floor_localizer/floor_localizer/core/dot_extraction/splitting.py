"""Splitting of touching dots: a blob with a waist is split, and hairs are removed from dots."""

import numpy as np
from numba import njit
from numpy.typing import NDArray

from floor_localizer.core.arrays import Booleans, Float32s, Ints, Pixels
from floor_localizer.core.dot_extraction.binarisation import SIGNS
from floor_localizer.core.dot_extraction.contrast import relative_contrast
from floor_localizer.core.dot_extraction.distance_watershed import distance_watershed
from floor_localizer.core.dot_extraction.labelling import DISCARDED, Boxes, Labels, bounding_boxes

# Maximum ratio of a waist for a split; ragged outlines of single chips have larger ratios, convex chips no waist.
_LARGEST_WAIST = 0.88
# Maximum radius of a hair as a fraction of the dot's.
_HAIR = 0.4
# Area over the area of the ellipse of equal moments: 1 for an ellipse, 0.90 for two equal adjacent discs,
# 0.83 for three; two discs are also at least 1.9 times as long as wide.
_ELLIPTIC = 0.98
_CLUSTERED = 0.94
_SHORT = 1.4
# Blobs with a larger area than this multiple of the median are split candidates, independent of their shape.
_LARGE = 1.6
# Maximum area of a cluster of dots, as a multiple of the largest dot's area.
_LARGEST_CLUSTER = 25.0
# Minimum area of a hair to remove, as a fraction of the blob's.
_SMALLEST_HAIR = 0.04
# Contrast of the outline in which waists are detected, as a fraction of the blob's: higher values tolerate more blur in
# the gap between two dots.
_OUTLINE = 0.67
# Approximate width of the raster on which a blob is split [px].
_RASTER = 22.0
# That outline shrinks small dots: minimum ratio of a part's diameter to that of the smallest dot.
_THINNED = 0.7


def split_touching(
    labels: Labels,
    boxes: Boxes,
    image: Pixels,
    background: Float32s,
    polarity: str,
    smallest_diameter: float,
    largest_diameter: float,
) -> tuple[Boxes, Booleans]:
    """Split blobs that consist of several dots, in place: each part gets its own label.

    The outline is computed from the unsmoothed image, because smoothing fills the gaps between dots. Of a split blob,
    pixels adjacent to the parts become floor and hairs ``DISCARDED``. Diameters are the minimum of a part and the
    maximum of a dot [px].

    Returns:
        the bounding boxes of the blobs, followed by those of the new parts; and which of these are parts of a blob.
    """
    smallest_area = 0.25 * np.pi * smallest_diameter**2
    largest_area = _LARGEST_CLUSTER * 0.25 * np.pi * largest_diameter**2
    candidates = _candidates(labels, boxes, smallest_area, largest_area)
    boxes, split = _split(labels, boxes, image, background, SIGNS[polarity], candidates, smallest_diameter)
    return np.asarray(boxes, dtype=np.int32), np.asarray(split, dtype=np.bool_)


@njit(cache=True, error_model='numpy')
def _split(
    labels: Labels,
    boxes: Boxes,
    image: Pixels,
    background: Float32s,
    sign: float,
    candidates: Ints,
    smallest_diameter: float,
) -> tuple[Boxes, Booleans]:
    is_part = np.zeros(len(boxes), np.bool_)
    for i in candidates:
        left, top, right, bottom, area = boxes[i]
        scale = min(4, max(1, round(_RASTER / area**0.5)))
        patch = labels[top:bottom, left:right]
        contrast = relative_contrast(image[top:bottom, left:right], background[top:bottom, left:right], sign)
        raster = _outline_raster(patch, i + 1, contrast, scale)
        smallest_radius = 0.5 * _THINNED * scale * smallest_diameter
        basins, parts = distance_watershed(raster, _HAIR, _LARGEST_WAIST, smallest_radius)
        count = len(boxes)
        relabelled = _relabel(patch, i + 1, basins, scale, count)
        if parts > 1 or _count_label(DISCARDED, relabelled) > _SMALLEST_HAIR * area:
            _copy(relabelled, patch)
            found = bounding_boxes(relabelled, count + parts - 1)
            for k in range(len(found)):
                found[k, 0] += left
                found[k, 1] += top
                found[k, 2] += left
                found[k, 3] += top
            for k in range(5):
                boxes[i, k] = found[i, k]
            boxes = np.concatenate((boxes, found[count:]))
            is_part = np.concatenate((is_part, np.ones(parts - 1, np.bool_)))
            is_part[i] = True
    return boxes, is_part


@njit(cache=True, error_model='numpy')
def _count_label(label: int, labels: Labels) -> int:
    count = 0
    for v in range(labels.shape[0]):
        for u in range(labels.shape[1]):
            count += labels[v, u] == label
    return count


@njit(cache=True, error_model='numpy')
def _copy(labels: Labels, target: Labels) -> None:
    for v in range(labels.shape[0]):
        for u in range(labels.shape[1]):
            target[v, u] = labels[v, u]


@njit(cache=True, error_model='numpy')
def _candidates(labels: Labels, boxes: Boxes, smallest_area: float, largest_area: float) -> Ints:
    found = np.empty(len(boxes), np.int64)
    count = 0
    areas = boxes[boxes[:, 4] >= smallest_area, 4]
    large = _LARGE * np.median(areas) if len(areas) > 0 else 0.0
    for i in range(len(boxes)):
        if not 2.0 * smallest_area <= boxes[i, 4] <= largest_area:
            continue
        if boxes[i, 4] > large or not _is_single(labels, boxes[i], i + 1):
            found[count] = i
            count += 1
    return found[:count]


@njit(cache=True, error_model='numpy')
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


@njit(cache=True, error_model='numpy')
def _outline_raster(labels: Labels, label: int, contrast: Float32s, scale: int) -> Pixels:
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
    # A border of zeros keeps the watershed inside the raster.
    raster = np.zeros((rows * scale + 2, columns * scale + 2), np.uint8)
    for row in range(rows * scale):
        y = (row + 0.5) / scale - 0.5
        for column in range(columns * scale):
            x = (column + 0.5) / scale - 0.5
            raster[row + 1, column + 1] = _interpolate(contrast, y, x) > level
    return raster


@njit(cache=True, error_model='numpy')
def _interpolate(values: Float32s, y: float, x: float) -> float:
    y, x = min(max(y, 0.0), values.shape[0] - 1.0), min(max(x, 0.0), values.shape[1] - 1.0)
    v, u = int(y), int(x)
    lower, right = min(v + 1, values.shape[0] - 1), min(u + 1, values.shape[1] - 1)
    above = values[v, u] + (x - u) * (values[v, right] - values[v, u])
    below = values[lower, u] + (x - u) * (values[lower, right] - values[lower, u])
    return above + (y - v) * (below - above)


@njit(cache=True, error_model='numpy')
def _relabel(labels: Labels, label: int, basins: NDArray[np.int32], scale: int, count: int) -> NDArray[np.int32]:
    # The first part keeps the blob's label; the others get new labels. Pixels adjacent to a part are its soft edge and
    # become floor; pixels farther away belong to no dot.
    height, width = labels.shape
    result = labels.copy()
    middle = 1 + scale // 2
    for v in range(height):
        for u in range(width):
            if labels[v, u] != label:
                continue
            basin = basins[middle + v * scale, middle + u * scale]
            if basin > 0:
                result[v, u] = label if basin == 1 else count + basin - 1
                continue
            result[v, u] = DISCARDED
            for y in range(max(0, v - 1), min(height, v + 2)):
                for x in range(max(0, u - 1), min(width, u + 2)):
                    if basins[middle + y * scale, middle + x * scale] > 0:
                        result[v, u] = 0
    return result
