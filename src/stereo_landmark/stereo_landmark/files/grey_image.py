"""Loads and encodes grey images."""

from __future__ import annotations

from pathlib import Path

import cv2
import numpy as np
from numpy.typing import NDArray

from shirube_ros.camera.files import load_image


def load_grey_image(path: Path) -> NDArray[np.uint8]:
    """Load an image as grey, shape (h, w).

    Raises:
        ImageFileError: the file is not an image, is truncated, or has more than 8 bits per channel.
    """
    return to_grey(load_image(path))


def to_grey(pixels: NDArray[np.uint8]) -> NDArray[np.uint8]:
    """Convert an image to grey, shape (h, w).

    Args:
        pixels: grey image, shape (h, w), or BGR image, shape (h, w, 3).
    """
    if pixels.ndim == 2:
        return pixels
    return np.asarray(cv2.cvtColor(pixels, cv2.COLOR_BGR2GRAY), dtype=np.uint8)


def encode_png(image: NDArray[np.uint8]) -> bytes:
    """Encode a grey image, shape (h, w), as PNG."""
    _, data = cv2.imencode('.png', image)
    return data.tobytes()
