"""Centroids, sizes and shapes of blobs, to a fraction of a pixel."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numba import njit
from numpy.typing import NDArray

from floor_localizer.core.dot_extraction.image_noise import noise_at
from floor_localizer.core.dot_extraction.labelling import Boxes, Labels
from floor_localizer.core.dot_extraction.surroundings import REACH

Image = NDArray[np.uint8]
Field = NDArray[np.float32]
Vector = NDArray[np.float64]
Places = NDArray[np.int64]

# Pixels below are floor and above are dot; between, the dot covers them in part. So noise and texture of the
# floor and of the dot's inside are kept out, and the edge, which alone tells the place, is left.
_FLOOR_COVERAGE = 0.15
_DOT_COVERAGE = 0.85
_SATURATED = 250
# Saturated pixels on a floor brighter than this are floor.
_SATURATED_FLOOR = 225.0
# Whatever the noise: ragged edges, unevenly coloured chips, texture of the floor, compression [px].
_SHAPE_SIGMA = 0.008
# Nobody sees which of two touching dots a pixel between them belongs to [part of the diameter].
_SPLIT_SIGMA = 0.02

_U, _V, _AREA, _SIGMA, _UU, _UV, _VV, _CONTRAST, _STEP, _CLIPPED = range(10)


class Blobs(NamedTuple):
    """Blobs of one image; n of them.

    Attributes:
        pixels: shape (n, 2), centroids u, v [px].
        sigmas: shape (n,), standard deviation of a centroid along each axis [px].
        areas: shape (n,), areas, partly covered pixels counted in part [px^2].
        covariances: shape (n, 3), second moments uu, uv, vv of the outline [px^2].
        contrasts: shape (n,), contrast to the floor, relative to its luminance; 0 for an empty blob.
        steps: shape (n,), how much the floor's luminance changes over the blob in the units of the contrast.
        clipped: shape (n,), share of a blob and its soft edge that a reflection saturates.
    """

    pixels: NDArray[np.float64]
    sigmas: NDArray[np.float64]
    areas: NDArray[np.float64]
    covariances: NDArray[np.float64]
    contrasts: NDArray[np.float64]
    steps: NDArray[np.float64]
    clipped: NDArray[np.float64]


def measure_blobs(
    image: NDArray[np.uint8],
    background: NDArray[np.float32],
    mask: NDArray[np.uint8],
    labels: Labels,
    boxes: Boxes,
    split: NDArray[np.bool_],
) -> Blobs:
    """Measure each blob in its own surroundings.

    A pixel weighs as much as the dot covers of it: its difference from the floor along the blob's own
    colour, less the median of the ring, over the difference in the blob's inside.

    Args:
        image: shape (h, w, channels), grey levels, not smoothed.
        background: shape (h, w, channels), grey levels of the floor.
        mask: shape (h, w), the binary image.
        labels: the blobs, grown by ``grow_labels``.
        boxes: bounding boxes of the blobs before they grew.
        split: shape (n,), which of the blobs are parts of one.
    """
    noise = noise_at(image, (boxes[:, :2] + boxes[:, 2:4] - 1) // 2)
    table = _measure(image, background, mask, labels, boxes, noise, REACH)
    diameters = 2.0 * np.sqrt(table[:, _AREA] / np.pi)
    sigmas = np.sqrt(table[:, _SIGMA] ** 2 + _SHAPE_SIGMA**2 + (split * _SPLIT_SIGMA * diameters) ** 2)
    return Blobs(
        table[:, [_U, _V]],
        sigmas,
        table[:, _AREA],
        table[:, _UU : _VV + 1],
        table[:, _CONTRAST],
        table[:, _STEP],
        table[:, _CLIPPED],
    )


@njit(cache=True)
def _measure(
    image: Image, background: Field, mask: Image, labels: Labels, boxes: Boxes, noise: Vector, reach: int
) -> Vector:
    height, width = labels.shape
    table = np.zeros((len(boxes), 10))
    for i in range(len(boxes)):
        if boxes[i, 4] == 0:
            continue
        left, top = max(0, boxes[i, 0] - reach), max(0, boxes[i, 1] - reach)
        right, bottom = min(width, boxes[i, 2] + reach), min(height, boxes[i, 3] + reach)
        places, ring = _places(labels[top:bottom, left:right], i + 1, left, top)
        direction = _direction(image, background, mask, places)
        coverage = _coverage(image, background, mask, places, ring, direction, table[i])
        if table[i, _CONTRAST] <= 0.0:
            continue
        _centroid(coverage, places, table[i])
        if table[i, _AREA] > 0.0:
            _shape(mask, places, table[i])
            v, u = int(table[i, _V]), int(table[i, _U])
            deviation = noise[i] * _noise_gain(direction, table[i, _CONTRAST], background[v, u])
            table[i, _SIGMA] = _centroid_sigma(coverage, places, table[i]) * deviation
            table[i, _STEP] = _light_step(background, mask, places, direction)
            table[i, _CLIPPED] = _clipped(image, background, places)
    return table


@njit(cache=True)
def _places(patch: Labels, label: int, left: int, top: int) -> tuple[Places, Places]:
    # Rows and columns of a blob with its soft edge, and of its ring.
    places, ring = np.empty((patch.size, 2), np.int64), np.empty((patch.size, 2), np.int64)
    count = ring_count = 0
    for v in range(patch.shape[0]):
        for u in range(patch.shape[1]):
            if patch[v, u] == label:
                places[count, 0], places[count, 1] = top + v, left + u
                count += 1
            elif patch[v, u] == -label:
                ring[ring_count, 0], ring[ring_count, 1] = top + v, left + u
                ring_count += 1
    return places[:count], ring[:ring_count]


@njit(cache=True)
def _direction(image: Image, background: Field, mask: Image, places: Places) -> Vector:
    # Unit vector of the blob's mean difference from the floor, over the channels.
    direction = np.zeros(image.shape[2])
    for k in range(len(places)):
        v, u = places[k, 0], places[k, 1]
        if mask[v, u]:
            for c in range(image.shape[2]):
                direction[c] += image[v, u, c] / background[v, u, c] - 1.0
    return direction / max(np.sqrt(np.sum(direction**2)), 1e-12)


@njit(cache=True)
def _differences(image: Image, background: Field, places: Places, direction: Vector) -> Vector:
    result = np.zeros(len(places))
    for k in range(len(places)):
        v, u = places[k, 0], places[k, 1]
        for c in range(image.shape[2]):
            result[k] += direction[c] * (image[v, u, c] / background[v, u, c] - 1.0)
    return result


@njit(cache=True)
def _coverage(
    image: Image, background: Field, mask: Image, places: Places, ring: Places, direction: Vector, row: Vector
) -> Vector:
    coverage = _differences(image, background, places, direction)
    if len(ring) > 0:
        coverage -= np.median(_differences(image, background, ring, direction))
    core = np.empty(len(places))
    count = 0
    for k in range(len(places)):
        if mask[places[k, 0], places[k, 1]]:
            core[count] = coverage[k]
            count += 1
    if count > 0:
        # The upper quarter: a small dot has few pixels that it covers wholly.
        row[_CONTRAST] = np.mean(np.partition(core[:count], (3 * count) // 4)[(3 * count) // 4 :])
    return coverage / max(row[_CONTRAST], 1e-6)


@njit(cache=True)
def _centroid(coverage: Vector, places: Places, row: Vector) -> None:
    area = su = sv = 0.0
    for k in range(len(places)):
        part = (coverage[k] - _FLOOR_COVERAGE) / (_DOT_COVERAGE - _FLOOR_COVERAGE)
        part = min(1.0, max(0.0, part))
        area += part
        su += part * places[k, 1]
        sv += part * places[k, 0]
    row[_AREA] = area
    if area > 0.0:
        row[_U], row[_V] = su / area, sv / area


@njit(cache=True)
def _shape(mask: Image, places: Places, row: Vector) -> None:
    n = mu = mv = muu = muv = mvv = 0.0
    for k in range(len(places)):
        v, u = places[k, 0], places[k, 1]
        if mask[v, u]:
            x, y = u - row[_U], v - row[_V]
            n += 1.0
            mu += x
            mv += y
            muu += x * x
            muv += x * y
            mvv += y * y
    n = max(n, 1.0)
    row[_UU] = muu / n - (mu / n) ** 2 + 1.0 / 12.0
    row[_UV] = muv / n - mu * mv / n**2
    row[_VV] = mvv / n - (mv / n) ** 2 + 1.0 / 12.0


@njit(cache=True)
def _noise_gain(direction: Vector, contrast: float, background: Field) -> float:
    # Noise of a pixel's coverage for each grey level of noise on the floor. Edges of light dots are brighter
    # than the floor, and photon noise grows with the root of the light.
    brightness = np.maximum(1.0, 1.0 + 0.5 * contrast * direction)
    return np.sqrt(np.sum(brightness * (direction / background) ** 2)) / contrast


@njit(cache=True)
def _centroid_sigma(coverage: Vector, places: Places, row: Vector) -> float:
    # Propagation of unit noise of the coverage; pixels clipped to floor or dot do not pass theirs on.
    total = 0.0
    for k in range(len(places)):
        if _FLOOR_COVERAGE < coverage[k] < _DOT_COVERAGE:
            total += 0.5 * ((places[k, 1] - row[_U]) ** 2 + (places[k, 0] - row[_V]) ** 2)
    return np.sqrt(total) / (row[_AREA] * (_DOT_COVERAGE - _FLOOR_COVERAGE))


@njit(cache=True)
def _clipped(image: Image, background: Field, places: Places) -> float:
    clipped = 0
    for k in range(len(places)):
        v, u = places[k, 0], places[k, 1]
        for c in range(image.shape[2]):
            if image[v, u, c] >= _SATURATED and background[v, u, c] < _SATURATED_FLOOR:
                clipped += 1
                break
    return clipped / len(places)


@njit(cache=True)
def _light_step(background: Field, mask: Image, places: Places, direction: Vector) -> float:
    # Floor in the light taken for floor in the shade would have this contrast, or the other way round.
    darkest, brightest = np.inf, 0.0
    for k in range(len(places)):
        v, u = places[k, 0], places[k, 1]
        if mask[v, u]:
            brightness = np.sum(background[v, u])
            darkest, brightest = min(darkest, brightness), max(brightest, brightness)
    if np.sum(direction) > 0.0:
        return brightest / darkest - 1.0
    return 1.0 - darkest / brightest
