"""Listing and loading of image files."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path

import cv2
import numpy as np
from numpy.typing import NDArray

from shirube_ros.file_errors import ImageFileError
from shirube_ros.image_integrity import is_truncated

_SUFFIXES = frozenset({'.bmp', '.jpeg', '.jpg', '.pgm', '.png', '.ppm', '.tif', '.tiff', '.webp'})


def list_images(paths: Sequence[Path]) -> list[Path]:
    """Return the given files, and for a folder its images in alphabetical order.

    Raises:
        ImageFileError: a path that does not exist, or a folder without images.
    """
    images: list[Path] = []
    for path in paths:
        if not path.exists():
            raise ImageFileError(f'{path}: does not exist; give images or a folder of images')
        if path.is_dir():
            found = sorted(each for each in path.iterdir() if each.suffix.lower() in _SUFFIXES)
            if not found:
                raise ImageFileError(f'{path}: has no images in it; give a folder of PNG or JPEG files')
            images += found
        else:
            images.append(path)
    return images


def load_image(path: Path) -> NDArray[np.uint8]:
    """Load one image.

    Returns:
        array, shape (h, w) for grey or (h, w, 3) in order blue, green, red.

    Raises:
        ImageFileError: the file is not an image, is truncated, or has more than 8 bits per channel.
    """
    try:
        data = np.frombuffer(path.read_bytes(), dtype=np.uint8)
    except OSError as fault:
        raise ImageFileError(f'{path}: cannot be read ({fault.strerror}); give an image') from fault
    if is_truncated(data):
        raise ImageFileError(f'{path}: is truncated; copy or record it again')
    try:
        pixels = cv2.imdecode(data, cv2.IMREAD_UNCHANGED) if len(data) else None
    except cv2.error:
        pixels = None
    if pixels is None:
        raise ImageFileError(f'{path}: is no image, or corrupted; give a PNG or JPEG file')
    if pixels.dtype != np.uint8:
        raise ImageFileError(f'{path}: has {8 * pixels.itemsize} bits per channel; convert it to 8')
    if pixels.ndim == 3 and pixels.shape[2] == 4:
        pixels = cv2.cvtColor(pixels, cv2.COLOR_BGRA2BGR)
    return np.asarray(pixels, dtype=np.uint8)
