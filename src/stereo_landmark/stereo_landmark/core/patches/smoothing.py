"""Images as cubic splines: smooth between the pixels, with the same smoothness wherever one looks.

The pixels, smoothed once, are taken for the coefficients of a spline. So the smoothing of a taught patch and of the
image that it is looked for in are the same at every part of a pixel, and no part of a pixel is preferred; what is too
fine for the pixels, and differs from image to image, counts little.
"""

from __future__ import annotations

import cv2
import numpy as np
from numpy.typing import NDArray

KERNEL = np.array([1.0, 4.0, 1.0]) / 6.0
"""The cubic spline at its nodes."""
NOISE = float(np.sum(np.convolve(KERNEL, KERNEL) ** 2) ** 2)
"""Variance of a smoothed value, of pixels with variance 1 each."""


def coefficients_of(image: NDArray[np.uint8] | NDArray[np.float32]) -> NDArray[np.float32]:
    """Return the coefficients of the spline that shows an image, shape (h, w) as the image."""
    return _filtered(image, KERNEL, KERNEL)


def derivatives_of(coefficients: NDArray[np.float32]) -> tuple[NDArray[np.float32], ...]:
    """Return the spline and its first and second derivatives to the right and down, at the pixels, each (h, w)."""
    slope, bend = np.array([-0.5, 0.0, 0.5]), np.array([1.0, -2.0, 1.0])
    return (
        _filtered(coefficients, KERNEL, KERNEL),
        _filtered(coefficients, slope, KERNEL),
        _filtered(coefficients, KERNEL, slope),
        _filtered(coefficients, bend, KERNEL),
        _filtered(coefficients, KERNEL, bend),
    )


def smoothed(columns: NDArray[np.float64]) -> NDArray[np.float64]:
    """Return pictures, shape (h, w, n), smoothed as the spline shows an image at its pixels."""
    twice = np.convolve(KERNEL, KERNEL)
    return np.dstack([cv2.sepFilter2D(columns[..., k], -1, twice, twice) for k in range(columns.shape[2])])


def _filtered(
    image: NDArray[np.uint8] | NDArray[np.float32], along: NDArray[np.float64], down: NDArray[np.float64]
) -> NDArray[np.float32]:
    return np.asarray(cv2.sepFilter2D(image, cv2.CV_32F, along, down), dtype=np.float32)
