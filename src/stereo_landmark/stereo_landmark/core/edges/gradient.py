"""Image gradient by derivatives of a Gaussian."""

from __future__ import annotations

import math

import cv2
import numpy as np
from numpy.typing import NDArray


def gaussian_gradient(
    image: NDArray[np.uint8], sigma: float
) -> tuple[NDArray[np.float32], NDArray[np.float32]]:
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
