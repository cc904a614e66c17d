"""Centre of a disc that a rolling shutter shows as bright and dark bands.

The position of the bands depends on when the lamp was lit, so an intensity centroid would be biased. But each bright
row ends left and right at the disc's rim, at half the row's brightness. A circle is fitted to these end points. Blobs
without a rim keep the centroid of the lamp with its bands closed, with a larger standard deviation.
"""

import math
from dataclasses import replace

import numpy as np
from numba import njit
from numpy.typing import NDArray

from vlc_beacon.core.lamp_image.blob_measurement import LampBlobs

LIT_FRACTION = 0.35
"""Minimum brightness of a row with rim points, as a fraction of the brightest."""
POINTS_MIN = 6
RESIDUAL_MAX = 0.12
"""Maximum RMS residual of the circle fit [lamp radii]."""
UNFITTED_SIGMAS = (0.05, 0.25)
"""Standard deviation along rows and columns if no circle is found [lamp radii]."""
SIGMA_MIN = 0.03
ITERATIONS = 8
OUTLIER_FACTOR = 3.0


def fit_striped_disc(image: NDArray[np.uint8], blobs: LampBlobs, noise: float) -> LampBlobs:
    """Return the blobs with centroids, sigmas and radii of circles fitted to their rims; noise in grey levels."""
    centroids, sigmas, radii = blobs.centroids.copy(), blobs.sigmas.copy(), blobs.radii.copy()
    for i in range(len(blobs)):
        points = find_rim_points(image, centroids[i], radii[i], blobs.backgrounds[i], 4.0 * noise)
        circle = _fit_circle(points) if len(points) >= POINTS_MIN else np.empty(0)
        if len(circle) == 0:
            sigmas[i] = np.maximum(sigmas[i], np.array(UNFITTED_SIGMAS) * radii[i])
            continue
        centroids[i], radii[i], sigmas[i] = circle[:2], circle[2], circle[3:]
    return replace(blobs, centroids=centroids, sigmas=sigmas, radii=radii)


@njit(cache=True)
def find_rim_points(
    image: NDArray[np.uint8], centre: NDArray[np.float64], radius: float, background: float, dimmest: float
) -> NDArray[np.float64]:
    """Return the end points of bright rows, shape (n, 2) [px].

    Args:
        image: grey image, shape (h, w).
        centre: approximate centre of the lamp, shape (2,) [px].
        radius: approximate radius [px].
        background: brightness of the background [grey levels].
        dimmest: minimum brightness of a row above the background [grey levels].
    """
    extent = 1.8 * radius + 3.0
    first, last = max(int(centre[1] - extent), 0), min(int(centre[1] + extent) + 1, image.shape[0] - 1)
    left, right = max(int(centre[0] - extent), 0), min(int(centre[0] + extent) + 1, image.shape[1] - 1)
    inner_left = max(round(centre[0] - 0.3 * radius), left)
    inner_right = min(round(centre[0] + 0.3 * radius), right)
    levels = np.zeros(last - first + 1)
    for row in range(first, last + 1):
        total = 0.0
        for column in range(inner_left, inner_right + 1):
            total += image[row, column]
        levels[row - first] = total / (inner_right - inner_left + 1) - background
    lit = max(LIT_FRACTION * levels.max(), dimmest)
    points = np.empty((2 * len(levels), 2))
    count = 0
    for row in range(first, last + 1):
        if levels[row - first] < lit:
            continue
        half = background + 0.5 * levels[row - first]
        start = round(centre[0])
        for sign in (-1, 1):
            column = start
            while left <= column + sign <= right and image[row, column + sign] >= half:
                column += sign
            if column + sign < left or column + sign > right or image[row, column] < half:
                continue
            inside, outside = float(image[row, column]), float(image[row, column + sign])
            points[count, 0] = column + sign * (inside - half) / max(inside - outside, 1e-9)
            points[count, 1] = row
            count += 1
    return points[:count]


@njit(cache=True)
def _fit_circle(points: NDArray[np.float64]) -> NDArray[np.float64]:
    """Return u, v, radius and the sigmas of u and v [px], shape (5,); shape (0,) if no circle fits the points."""
    middle = np.array([points[:, 0].mean(), points[:, 1].mean()])
    local = points - middle
    rows = np.column_stack((2.0 * local, np.ones((len(local), 1))))
    solution, _, rank, _ = np.linalg.lstsq(rows, (local**2).sum(axis=1))
    squared = solution[2] + solution[0] ** 2 + solution[1] ** 2
    if rank < 3 or squared <= 0.0:
        return np.empty(0)
    circle = np.array([solution[0], solution[1], math.sqrt(squared)])
    used = np.ones(len(local), dtype=np.bool_)
    information = np.eye(3)
    rms = 0.0
    for _ in range(ITERATIONS):
        offsets = local - circle[:2]
        distances = np.hypot(offsets[:, 0], offsets[:, 1])
        residuals = distances - circle[2]
        rms = math.sqrt(np.mean(residuals[used] ** 2))
        used = np.abs(residuals) <= max(OUTLIER_FACTOR * rms, 0.2)
        ones = np.ones((len(local), 1))
        jacobian = np.column_stack((-offsets / np.maximum(distances, 1e-9).reshape(-1, 1), -ones))[used]
        information = jacobian.T @ jacobian
        if len(jacobian) < POINTS_MIN or np.linalg.cond(information) > 1e6:
            return np.empty(0)
        circle = circle - np.linalg.solve(information, jacobian.T @ residuals[used])
    extent = 0.5 * max(np.ptp(points[:, 0]), np.ptp(points[:, 1]))
    if rms > RESIDUAL_MAX * circle[2] or circle[2] > 2.0 * extent or not circle[2] > 0.0:
        return np.empty(0)
    inflation = len(points) / max(len(points) - 3, 1)
    variances = np.diag(np.linalg.inv(information))[:2] * rms**2 * inflation
    return np.concatenate((circle[:2] + middle, circle[2:], np.sqrt(variances + SIGMA_MIN**2)))
