"""Local contrast of an image on a coarse grid: fast, with reduced noise."""

from __future__ import annotations

import math

import cv2
import numpy as np
from numpy.typing import NDArray

CELL = 4
"""Side length of a cell [px]."""
BACKGROUND_CELLS = 4
"""Side length of a cell of the background image [cells]."""
NOISE_ROWS = 32
_NORMAL_MAD = 0.6745
NOISE_MIN = 0.3
"""Quantization noise [grey levels]."""


def coarse_contrast(
    image: NDArray[np.uint8], diameter_max: float, stripe_rows: float
) -> tuple[NDArray[np.uint8], NDArray[np.uint8]]:
    """Return contrast and background, both of shape (h // CELL, w // CELL) [grey levels].

    The background is a morphological opening with a kernel larger than a lamp. Before it, a closing along the columns
    fills the dark bands of a rolling shutter.

    Args:
        image: grey image, shape (h, w).
        diameter_max: maximum lamp diameter [px].
        stripe_rows: maximum height of a dark band in a lamp [px], 0 for none.
    """
    height, width = image.shape
    size = width // CELL, height // CELL
    coarse = cv2.resize(image[: size[1] * CELL, : size[0] * CELL], size, interpolation=cv2.INTER_AREA)
    if stripe_rows > 0.0:
        column = np.ones((1 + math.ceil(stripe_rows / CELL), 1), np.uint8)
        coarse = cv2.morphologyEx(coarse, cv2.MORPH_CLOSE, column)
    downsampled = cv2.resize(
        coarse,
        (max(size[0] // BACKGROUND_CELLS, 1), max(size[1] // BACKGROUND_CELLS, 1)),
        interpolation=cv2.INTER_AREA,
    )
    side = 1 + 2 * math.ceil(0.5 * diameter_max / (CELL * BACKGROUND_CELLS) + 1.0)
    # Limit the kernel to the size of the image.
    kernel = np.ones(
        (min(side, 2 * downsampled.shape[0] - 1), min(side, 2 * downsampled.shape[1] - 1)), np.uint8
    )
    opened = cv2.morphologyEx(downsampled, cv2.MORPH_OPEN, kernel)
    background = cv2.resize(opened, size, interpolation=cv2.INTER_LINEAR)
    return cv2.subtract(coarse, background), background


def noise_sigma(image: NDArray[np.uint8]) -> float:
    """Estimate the noise standard deviation of a pixel [grey levels] from second differences along rows."""
    step = max(image.shape[0] // NOISE_ROWS, 1)
    rows = image[step // 2 :: step].astype(np.int16)
    differences = rows[:, :-2] - 2 * rows[:, 1:-1] + rows[:, 2:]
    # The median of integers is coarse; the mean square of the small differences is not.
    magnitude = np.abs(differences)
    typical = float(np.median(magnitude))
    low = magnitude[magnitude <= 3.0 * typical + 1.0]
    spread = math.sqrt(float(np.mean(low.astype(np.float64) ** 2))) if len(low) else 0.0
    return max(max(spread, typical / _NORMAL_MAD) / math.sqrt(6.0), NOISE_MIN)
