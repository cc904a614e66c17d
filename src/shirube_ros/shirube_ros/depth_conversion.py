"""Conversion of depth images to arrays (REP-118)."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray
from sensor_msgs.msg import Image

from shirube_ros.message_error import ImageError

_TYPES: dict[str, np.dtype[np.uint16] | np.dtype[np.float32]] = {
    '16UC1': np.dtype(np.uint16),
    'mono16': np.dtype(np.uint16),
    '32FC1': np.dtype(np.float32),
}
_MILLIMETRE = 1e-3


def depth_from_image(message: Image, topic: str) -> NDArray[np.float32]:
    """Return a depth image, shape (height, width) [m]; NaN where there is no depth.

    Args:
        message: 32FC1 in metres, or 16UC1 in millimetres with 0 for no depth.
        topic: name for error messages.

    Raises:
        ImageError: unsupported encoding, big-endian data, or data that does not match the size.
    """
    kind = _TYPES.get(message.encoding)
    if kind is None or message.is_bigendian:
        raise ImageError(
            f'{topic} has the encoding {message.encoding!r}, is_bigendian {message.is_bigendian}; '
            'send 32FC1 (metres) or 16UC1 (millimetres), little endian'
        )
    height, width, step = message.height, message.width, message.step
    if height == 0 or width == 0 or step < width * kind.itemsize:
        raise ImageError(
            f'{topic} is {width} x {height} px with rows of {step} bytes; check the camera driver'
        )
    if len(message.data) < step * (height - 1) + width * kind.itemsize:
        raise ImageError(f'{topic} is truncated; check the camera driver and the network')
    raw: NDArray[np.generic] = np.ndarray(
        (height, width), kind, buffer=message.data, strides=(step, kind.itemsize)
    )
    if kind.kind == 'f':
        return np.ascontiguousarray(raw, dtype=np.float32)
    depth = raw.astype(np.float32) * np.float32(_MILLIMETRE)
    depth[depth == 0.0] = np.nan
    return depth
