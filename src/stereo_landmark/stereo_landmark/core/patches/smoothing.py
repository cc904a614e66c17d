"""Cubic B-spline interpolation of images with the same smoothing at every subpixel position.

The smoothed pixels serve as spline coefficients. The taught patch and the image have the same smoothing at every
subpixel position, so the alignment has no subpixel bias; detail that the pixels undersample has little weight.
"""

from __future__ import annotations

import cv2
import numpy as np
from numpy.typing import NDArray

SPLINE_KERNEL = np.array([1.0, 4.0, 1.0]) / 6.0
"""Cubic B-spline at its knots."""
NOISE_GAIN = float(np.sum(np.convolve(SPLINE_KERNEL, SPLINE_KERNEL) ** 2) ** 2)
"""Variance of a smoothed value for pixels with variance 1."""


def spline_coefficients(image: NDArray[np.uint8] | NDArray[np.float32]) -> NDArray[np.float32]:
    """Return the spline coefficients of an image, shape (h, w)."""
    return _separable_filter(image, SPLINE_KERNEL, SPLINE_KERNEL)


def spline_derivatives(coefficients: NDArray[np.float32]) -> tuple[NDArray[np.float32], ...]:
    """Return the spline, its first and its second derivatives along x and y at the pixels, each of shape (h, w)."""
    slope, bend = np.array([-0.5, 0.0, 0.5]), np.array([1.0, -2.0, 1.0])
    return (
        _separable_filter(coefficients, SPLINE_KERNEL, SPLINE_KERNEL),
        _separable_filter(coefficients, slope, SPLINE_KERNEL),
        _separable_filter(coefficients, SPLINE_KERNEL, slope),
        _separable_filter(coefficients, bend, SPLINE_KERNEL),
        _separable_filter(coefficients, SPLINE_KERNEL, bend),
    )


def smooth_images(images: NDArray[np.float64]) -> NDArray[np.float64]:
    """Return images, shape (h, w, n), with the smoothing of the spline at the pixels."""
    twice = np.convolve(SPLINE_KERNEL, SPLINE_KERNEL)
    return np.dstack([cv2.sepFilter2D(images[..., k], -1, twice, twice) for k in range(images.shape[2])])


def _separable_filter(
    image: NDArray[np.uint8] | NDArray[np.float32], along: NDArray[np.float64], down: NDArray[np.float64]
) -> NDArray[np.float32]:
    return np.asarray(cv2.sepFilter2D(image, cv2.CV_32F, along, down), dtype=np.float32)
