"""Aligns small patches of the taught left image with other images, to a fraction of a pixel (Lucas & Kanade 1981).

A patch moves by a known linear map, which the hypothetical pose predicts, and an unknown shift; gain and offset of its
grey levels are free. All images are compared with the taught left one, so that all positions are of the same point.
"""

from typing import NamedTuple

import cv2
import numpy as np
from numba import njit

from stereo_landmark.core.arrays import Floats, GreyImage, Ints

RADIUS = 7
"""Half the side of a patch [px]."""
ITERATIONS_MAX = 10
STEP_TOLERANCE = 0.01
"""The alignment stops when the step is smaller [px]."""
MOTIONS = 6
"""A shift along two axes and four elements of a linear map."""
SHEAR_STIFFNESS = 0.02
"""Weight of the predicted map against the grey levels."""
SHIFT_STIFFNESS = 1e-6
"""The same of the predicted position: enough for an invertible matrix."""
SMOOTHING_SIGMA = 0.8
"""Smoothing before the interpolation between pixels [px]."""


class AlignedPatches(NamedTuple):
    """Positions of patches in an image.

    Attributes:
        pixels: positions of the centres, shape (n, 2) [px].
        correlations: normalized correlations with the template, shape (n,); -1 outside of the image or without a fit.
        covariances: covariances of the positions by the noise of both images, shape (n, 2, 2) [px²].
    """

    pixels: Floats
    correlations: Floats
    covariances: Floats


def smooth(image: GreyImage) -> Floats:
    """Return a smoothed image for `align_patches`, shape (h, w)."""
    return np.asarray(cv2.GaussianBlur(image.astype(np.float32), (0, 0), SMOOTHING_SIGMA), dtype=np.float32)


class Patches(NamedTuple):
    """Patches of the taught left image.

    Attributes:
        levels: grey levels of zero mean and unit norm, shape (n, p), float32.
        slopes: their derivatives by the motions, shape (n, p, MOTIONS), float32.
        inverses: inverse normal matrices of the motions, shape (n, MOTIONS, MOTIONS), float32; NaN without texture.
    """

    levels: np.ndarray
    slopes: np.ndarray
    inverses: np.ndarray


def cut_patches(template: Floats, centres: Floats) -> Patches:
    """Return the patches around centres, shape (n, 2) [px], in a smoothed image."""
    size = (2 * RADIUS + 1) ** 2
    levels, slopes = np.zeros((len(centres), size), np.float32), np.zeros((len(centres), size, MOTIONS), np.float32)
    inverses = np.full((len(centres), MOTIONS, MOTIONS), np.nan, np.float32)
    _cut(template, np.ascontiguousarray(centres), levels, slopes, inverses)
    return Patches(levels, slopes, inverses)


def align_patches(patches: Patches, chosen: Ints, image: Floats, starts: Floats, maps: Floats) -> AlignedPatches:
    """Align patches with an image.

    Args:
        patches: patches of the taught left image.
        chosen: indices of those to align, shape (n,).
        image: smoothed image.
        starts: predicted centres in the image, shape (n, 2) [px].
        maps: linear maps from offsets in the template to offsets in the image, shape (n, 2, 2).
    """
    pixels, correlations = np.ascontiguousarray(starts, dtype=np.float64).copy(), np.full(len(chosen), -1.0)
    covariances = np.zeros((len(chosen), 2, 2))
    _align(patches, chosen, image, pixels, maps.copy(), correlations, covariances)
    return AlignedPatches(pixels, correlations, covariances)


@njit(cache=True, error_model='numpy', inline='always')
def _sample(image: Floats, u: float, v: float) -> float:
    """Return the grey level between pixels (bilinear)."""
    i, j = int(v), int(u)
    a, b = v - i, u - j
    upper = image[i, j] + b * (image[i, j + 1] - image[i, j])
    lower = image[i + 1, j] + b * (image[i + 1, j + 1] - image[i + 1, j])
    return upper + a * (lower - upper)


@njit(cache=True, error_model='numpy', inline='always')
def _is_inside(image: Floats, u: float, v: float, margin: float) -> bool:
    """Return whether a patch is inside of an image, false for NaN."""
    return u > margin and v > margin and u < image.shape[1] - 2.0 - margin and v < image.shape[0] - 2.0 - margin


@njit(cache=True, error_model='numpy')
def _cut(template: Floats, centres: Floats, levels: Floats, slopes: Floats, inverses: Floats) -> None:
    """Write the patches."""
    for n in range(len(centres)):
        if not _is_inside(template, centres[n, 0], centres[n, 1], RADIUS + 1.0):
            continue
        _read_template(template, centres[n], levels[n], slopes[n])
        normal = slopes[n].T @ slopes[n]
        if normal[0, 0] * normal[1, 1] - normal[0, 1] ** 2 < 1e-3 * (normal[0, 0] + normal[1, 1]) ** 2:
            continue
        for c in range(MOTIONS):
            normal[c, c] += SHEAR_STIFFNESS if c > 1 else SHIFT_STIFFNESS
        inverses[n] = np.linalg.inv(normal)


@njit(cache=True, error_model='numpy')
def _align(
    patches: Patches,
    chosen: Ints,
    image: Floats,
    pixels: Floats,
    maps: Floats,
    correlations: Floats,
    covariances: Floats,
) -> None:
    """Write positions, maps, correlations and covariances of the chosen patches."""
    size = patches.levels.shape[1]
    seen, shift, step = np.empty(size, np.float32), np.empty((2, 2)), np.empty(MOTIONS)
    for n in range(len(chosen)):
        levels, slopes, inverse = patches.levels[chosen[n]], patches.slopes[chosen[n]], patches.inverses[chosen[n]]
        if np.isnan(inverse[0, 0]):
            continue
        linear = maps[n]
        for _ in range(ITERATIONS_MAX):
            reach = RADIUS * np.max(np.abs(linear[:, 0]) + np.abs(linear[:, 1])) + 1.0
            if not _is_inside(image, pixels[n, 0], pixels[n, 1], reach):
                correlations[n] = -1.0
                break
            cross = _read_levels(image, pixels[n], linear, levels, seen)
            correlations[n] = cross
            if cross <= 0.1:
                break
            step[:] = inverse @ (seen @ slopes) / cross
            for c in range(2):
                pixels[n, c] -= linear[c, 0] * step[0] + linear[c, 1] * step[1]
            shift[0, 0], shift[0, 1] = 1.0 - step[2] / RADIUS, -step[3] / RADIUS
            shift[1, 0], shift[1, 1] = -step[4] / RADIUS, 1.0 - step[5] / RADIUS
            linear[:] = linear @ shift
            if step[0] ** 2 + step[1] ** 2 < STEP_TOLERANCE**2:
                break
        variance = max(1.0 - correlations[n] ** 2, 1e-6) / size / max(correlations[n], 0.1) ** 2
        covariances[n] = variance * (linear @ inverse[:2, :2].astype(np.float64) @ linear.T)


@njit(cache=True, error_model='numpy')
def _read_template(template: Floats, centre: Floats, levels: Floats, slopes: Floats) -> None:
    """Write grey levels of a patch, of zero mean and unit norm, and their slopes by the motions: shift and shear."""
    k, mean = 0, 0.0
    for i in range(-RADIUS, RADIUS + 1):
        for j in range(-RADIUS, RADIUS + 1):
            u, v = centre[0] + j, centre[1] + i
            levels[k] = _sample(template, u, v)
            by_u = 0.5 * (_sample(template, u + 1.0, v) - _sample(template, u - 1.0, v))
            by_v = 0.5 * (_sample(template, u, v + 1.0) - _sample(template, u, v - 1.0))
            slopes[k, 0], slopes[k, 1] = by_u, by_v
            slopes[k, 2], slopes[k, 3] = by_u * j / RADIUS, by_u * i / RADIUS
            slopes[k, 4], slopes[k, 5] = by_v * j / RADIUS, by_v * i / RADIUS
            mean += levels[k]
            k += 1
    levels -= mean / k
    norm = np.sqrt(np.sum(levels * levels)) + 1e-9
    levels /= norm
    slopes /= norm
    for c in range(MOTIONS):
        slopes[:, c] -= np.mean(slopes[:, c])
        slopes[:, c] -= np.sum(slopes[:, c] * levels) * levels


@njit(cache=True, error_model='numpy')
def _read_levels(image: Floats, pixel: Floats, linear: Floats, levels: Floats, seen: Floats) -> float:
    """Write the seen levels, of zero mean and unit norm; return their correlation with the template."""
    k, mean = 0, 0.0
    for i in range(-RADIUS, RADIUS + 1):
        for j in range(-RADIUS, RADIUS + 1):
            u = pixel[0] + linear[0, 0] * j + linear[0, 1] * i
            v = pixel[1] + linear[1, 0] * j + linear[1, 1] * i
            seen[k] = _sample(image, u, v)
            mean += seen[k]
            k += 1
    seen -= mean / k
    seen /= np.sqrt(np.sum(seen * seen)) + 1e-9
    return float(np.sum(seen * levels))
