"""Numba kernels of patch alignment: weighted Gauss-Newton steps on a homography."""

import numpy as np
from numba import njit
from numpy.typing import NDArray

from stereo_landmark.core.arrays import Floats
from stereo_landmark.core.least_squares import invert_symmetric

HOMOGRAPHY_DOF = 8
"""Degrees of freedom of a homography."""
ITERATIONS_MAX = 6
STEP_TOLERANCE = 0.01
"""Steps smaller than this have converged [px]."""
STEP_MAX = 1.5
"""Largest step; a patch that moves farther at once is rejected [px]."""
TUKEY_CONSTANT = 4.7
MAD_TO_SIGMA = 1.4826
SCALE_SUBSAMPLING = 7
"""The residual scale is the MAD of every seventh pixel."""
SCALE_MIN = 0.05
"""Lower limit of the residual scale [grey levels]."""
INLIER_FRACTION_MIN = 0.7
"""Minimum fraction of inlier pixels."""
EXPLAINED_FRACTION_MIN = 0.9
"""Minimum fraction of the inliers' variance that the taught patch must explain."""
STRAIN_CELLS = 4
"""Cells along each side of the patch for the strain test: few enough to have texture, many enough to show motion."""
CELL_PIXELS_MIN = 20
GAIN_RANGE = 0.2, 5.0
GAIN_COLUMN, SOFT_COLUMN = HOMOGRAPHY_DOF, HOMOGRAPHY_DOF + 1
"""Columns of the sharp and of the blurred patch: the fraction that the image has of each."""


@njit(cache=True, error_model='numpy')
def fit_patch(
    image: NDArray[np.float32],
    coordinates: Floats,
    jacobian: Floats,
    soft_slope_ratio: float,
    scale: float,
    homography: Floats,
    inverse: Floats,
) -> tuple[float, float, float]:
    """Align the homography with the image.

    Args:
        image: spline coefficients of the image, shape (h, w).
        coordinates: patch coordinates of the pixels, shape (n, 2).
        jacobian: derivatives of the pixel values by homography, gain, blur and the other parameters, shape (n, p).
        soft_slope_ratio: slopes of the blurred patch relative to the slopes of the sharp one.
        scale: half width or height of the patch, the larger one [px].
        homography: map from patch coordinates to the image, shape (3, 3), off by a pixel at most; updated in place.
        inverse: inverse normal matrix, shape (p, p); on return the one with the final weights.

    Returns:
        residual variance, -1 if the patch is not there; gain of the slopes; and strain: relative motion of the cells,
        in variances of the motion that independent pixel noise of this size causes.
    """
    values, weights = np.empty(len(coordinates)), np.ones(len(coordinates))
    light, solution = np.ascontiguousarray(jacobian[:, HOMOGRAPHY_DOF:]), np.zeros(jacobian.shape[1])
    step, gain = np.inf, 1.0
    for k in range(ITERATIONS_MAX):
        if not _sample_image(image, coordinates, homography, values):
            return -1.0, 0.0, 0.0
        # Moved details bias the alignment until the weights reject them, by residuals without the motion.
        if k > 0:
            weights = _tukey_weights(values - light @ solution[HOMOGRAPHY_DOF:])
            if not invert_symmetric((jacobian * weights.reshape(-1, 1)).T @ jacobian, inverse):
                return -1.0, 0.0, 0.0
        solution = inverse @ ((weights * values) @ jacobian)
        gain = solution[GAIN_COLUMN] + soft_slope_ratio * solution[SOFT_COLUMN]
        if not GAIN_RANGE[0] < gain < GAIN_RANGE[1]:
            return -1.0, 0.0, 0.0
        step = _update_homography(homography, solution[:HOMOGRAPHY_DOF] / gain, scale)
        if step > STEP_MAX:
            return -1.0, 0.0, 0.0
        if k > 0 and step < STEP_TOLERANCE:
            break
    if step > 5.0 * STEP_TOLERANCE:
        return -1.0, 0.0, 0.0
    residuals = values - light @ solution[HOMOGRAPHY_DOF:]
    residual_variance = _inlier_variance(values, weights, residuals, len(solution))
    return residual_variance, gain, _strain(coordinates, jacobian, weights, residuals) / residual_variance


@njit(cache=True, error_model='numpy')
def _sample_image(image: NDArray[np.float32], coordinates: Floats, homography: Floats, values: Floats) -> bool:
    """Write the image values at the patch coordinates; False if one is outside the image."""
    height, width = image.shape
    h = homography
    for n in range(len(coordinates)):
        s, t = coordinates[n, 0], coordinates[n, 1]
        w = 1.0 / (h[2, 0] * s + h[2, 1] * t + h[2, 2])
        x = (h[0, 0] * s + h[0, 1] * t + h[0, 2]) * w
        y = (h[1, 0] * s + h[1, 1] * t + h[1, 2]) * w
        if not (1.0 <= x < width - 2.0 and 1.0 <= y < height - 2.0):
            return False
        i, j = int(x) - 1, int(y) - 1
        across, down = _spline_weights(np.float32(x - i - 1)), _spline_weights(np.float32(y - j - 1))
        total = np.float32(0.0)
        for r in range(4):
            four = image[j + r, i : i + 4]
            row = across[0] * four[0] + across[1] * four[1] + across[2] * four[2] + across[3] * four[3]
            total += down[r] * row
        values[n] = total
    return True


@njit(cache=True, error_model='numpy')
def _spline_weights(f: np.float32) -> tuple[np.float32, np.float32, np.float32, np.float32]:
    """Return the cubic B-spline weights of the four pixels around a fractional position."""
    sixth, half, g = np.float32(1.0 / 6.0), np.float32(0.5), np.float32(1.0) - f
    inner = np.float32(2.0 / 3.0)
    return (
        g * g * g * sixth,
        inner - f * f * (np.float32(1.0) - half * f),
        inner - g * g * (np.float32(1.0) - half * g),
        f * f * f * sixth,
    )


@njit(cache=True, error_model='numpy')
def _tukey_weights(residuals: Floats) -> Floats:
    limit = TUKEY_CONSTANT * max(MAD_TO_SIGMA * np.median(np.abs(residuals[::SCALE_SUBSAMPLING])), SCALE_MIN)
    return np.maximum(1.0 - (residuals / limit) ** 2, 0.0) ** 2


@njit(cache=True, error_model='numpy')
def _update_homography(homography: Floats, m: Floats, scale: float) -> float:
    """Compose the homography with the inverse update; return the approximate largest motion of the patch [px]."""
    motion = np.array([[1.0 + m[1], m[2], m[0]], [m[4], 1.0 + m[5], m[3]], [-m[6], -m[7], 1.0]])
    moved = homography @ np.linalg.inv(motion)
    homography[:] = moved / moved[2, 2]
    return scale * np.max(np.abs(m))


@njit(cache=True, error_model='numpy')
def _inlier_variance(values: Floats, weights: Floats, residuals: Floats, unknowns: int) -> float:
    """Return the residual variance of the inliers, -1 if they are too few or correlate too little with the patch."""
    is_inlier, total = weights > 0.0, float(np.sum(weights))
    squares = np.sum(weights * (values - weights @ values / max(total, 1e-9)) ** 2)
    inlier_count = int(np.sum(is_inlier))
    residual_variance = np.sum(residuals[is_inlier] ** 2) / max(inlier_count - unknowns, 1)
    if (
        inlier_count < INLIER_FRACTION_MIN * len(values)
        or residual_variance > (1.0 - EXPLAINED_FRACTION_MIN) * squares / total
    ):
        return -1.0
    return residual_variance


@njit(cache=True, error_model='numpy')
def _strain(coordinates: Floats, jacobian: Floats, weights: Floats, residuals: Floats) -> float:
    """Return the part of the residual variance that separate motions of the cells would explain."""
    sums, pixels = np.zeros((STRAIN_CELLS**2, 5)), np.zeros(STRAIN_CELLS**2, np.int64)
    for n in range(len(residuals)):
        if weights[n] > 0.0:
            i = min(max(int(0.5 * STRAIN_CELLS * (coordinates[n, 0] + 1.0)), 0), STRAIN_CELLS - 1)
            j = min(max(int(0.5 * STRAIN_CELLS * (coordinates[n, 1] + 1.0)), 0), STRAIN_CELLS - 1)
            cell, right, down = j * STRAIN_CELLS + i, weights[n] * jacobian[n, 0], weights[n] * jacobian[n, 3]
            pixels[cell] += 1
            sums[cell, 0] += right * residuals[n]
            sums[cell, 1] += down * residuals[n]
            sums[cell, 2] += right * right
            sums[cell, 3] += right * down
            sums[cell, 4] += down * down
    total, count = 0.0, 0
    for cell in range(STRAIN_CELLS**2):
        if pixels[cell] >= CELL_PIXELS_MIN:
            x, y, xx, xy, yy = sums[cell]
            # Aperture problem: parallel slopes say nothing about the motion along the edge.
            ridge = 1e-3 * (xx + yy)
            xx, yy = xx + ridge, yy + ridge
            total += (yy * x * x - 2.0 * xy * x * y + xx * y * y) / (xx * yy - xy * xy)
            count += 2
    return total / max(count - HOMOGRAPHY_DOF, 1)
