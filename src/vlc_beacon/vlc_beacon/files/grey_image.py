"""A grey image from a file."""

from __future__ import annotations

from pathlib import Path

import cv2
import numpy as np
from numpy.typing import NDArray

from vlc_beacon.core.vlc_beacon_error import VlcBeaconError


def load_grey_image(path: Path) -> NDArray[np.uint8]:
    """Load an image, shape (h, w); coloured ones become grey.

    Raises:
        VlcBeaconError: the file cannot be read, is no image, or has more than 8 bits a channel.
    """
    try:
        data = np.frombuffer(path.read_bytes(), dtype=np.uint8)
    except OSError as fault:
        raise VlcBeaconError(f'{path}: cannot be read ({fault.strerror}); give an image') from fault
    try:
        pixels = cv2.imdecode(data, cv2.IMREAD_ANYDEPTH) if len(data) else None
    except cv2.error:
        pixels = None
    if pixels is None:
        raise VlcBeaconError(f'{path}: is no image, or damaged; give a PNG or JPEG file')
    if pixels.dtype != np.uint8:
        raise VlcBeaconError(f'{path}: has {8 * pixels.itemsize} bits a channel; convert it to 8')
    return np.asarray(pixels, dtype=np.uint8)
