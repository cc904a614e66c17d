"""Grey images from files and into them."""

from __future__ import annotations

from pathlib import Path

import cv2
import numpy as np
from numpy.typing import NDArray

from shirube_ros.image_files import load_image


def load_grey_image(path: Path) -> NDArray[np.uint8]:
    """Load an image, shape (h, w); coloured ones become grey.

    Raises:
        ImageFileError: a file that is no image, is truncated, or has more than 8 bits a channel.
    """
    return grey(load_image(path))


def grey(pixels: NDArray[np.uint8]) -> NDArray[np.uint8]:
    """Return an image as grey, shape (h, w).

    Args:
        pixels: shape (h, w) grey or (h, w, 3) blue, green, red.
    """
    if pixels.ndim == 2:
        return pixels
    return np.asarray(cv2.cvtColor(pixels, cv2.COLOR_BGR2GRAY), dtype=np.uint8)


def png_bytes(image: NDArray[np.uint8]) -> bytes:
    """Return a grey image, shape (h, w), as a PNG file, without loss."""
    _, data = cv2.imencode('.png', image)
    return data.tobytes()
