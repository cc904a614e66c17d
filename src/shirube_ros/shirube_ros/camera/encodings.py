"""Decoding of the grey, colour, Bayer and YUV encodings of ``sensor_msgs/image_encodings`` to 8-bit grey or BGR.

16 bits become 8 as in cv_bridge: 65535 is white. A sensor of 10 or 12 bits must be scaled to 16 by its driver; if it is
not, its images are dark. YUV is that of ITU-R BT.601 with 16 to 235 for black to white, as V4L2 defines it.
"""

from dataclasses import dataclass
from fractions import Fraction

import cv2
import numpy as np
from numpy.typing import NDArray

Bytes = NDArray[np.uint8]


@dataclass(frozen=True)
class Encoding:
    """How the bytes of an image are read.

    Attributes:
        channels: numbers per pixel and row, for YUV those of the brightness or of the packed pair's half.
        bits: bits per number, 8 or 16.
        code: OpenCV's conversion to BGR, None if the pixels are grey or BGR.
        pixels_per_block: width is rounded up to a multiple of it.
        rows: rows of bytes per row of the image.
    """

    channels: int
    bits: int = 8
    code: int | None = None
    pixels_per_block: int = 1
    rows: Fraction = Fraction(1)

    def row_bytes(self, width: int) -> int:
        """Return the bytes of a row of an image, without padding."""
        blocks = -(-width // self.pixels_per_block)
        return blocks * self.pixels_per_block * self.channels * self.bits // 8

    def row_count(self, height: int) -> int:
        """Return the number of rows of bytes."""
        return -int(-height * self.rows // 1)


_BAYER = {
    'rggb': cv2.COLOR_BayerRGGB2BGR,
    'bggr': cv2.COLOR_BayerBGGR2BGR,
    'gbrg': cv2.COLOR_BayerGBRG2BGR,
    'grbg': cv2.COLOR_BayerGRBG2BGR,
}
_COLOURS = {
    'bgr': (3, None),
    'rgb': (3, cv2.COLOR_RGB2BGR),
    'bgra': (4, cv2.COLOR_BGRA2BGR),
    'rgba': (4, cv2.COLOR_RGBA2BGR),
}
_UYVY = Encoding(2, 8, cv2.COLOR_YUV2BGR_UYVY, 2)
_YUYV = Encoding(2, 8, cv2.COLOR_YUV2BGR_YUYV, 2)
ENCODINGS: dict[str, Encoding] = {
    **{f'mono{bits}': Encoding(1, bits) for bits in (8, 16)},
    **{f'{bits}UC1': Encoding(1, bits) for bits in (8, 16)},
    **{f'{bits}UC3': Encoding(3, bits) for bits in (8, 16)},
    **{f'{bits}UC4': Encoding(4, bits, cv2.COLOR_BGRA2BGR) for bits in (8, 16)},
    **{f'{name}{bits}': Encoding(n, bits, code) for name, (n, code) in _COLOURS.items() for bits in (8, 16)},
    **{f'bayer_{name}{bits}': Encoding(1, bits, code) for name, code in _BAYER.items() for bits in (8, 16)},
    'uyvy': _UYVY,
    'yuv422': _UYVY,
    'yuyv': _YUYV,
    'yuv422_yuy2': _YUYV,
    'nv12': Encoding(1, 8, cv2.COLOR_YUV2BGR_NV12, 2, Fraction(3, 2)),
    'nv21': Encoding(1, 8, cv2.COLOR_YUV2BGR_NV21, 2, Fraction(3, 2)),
    'nv24': Encoding(1, 8, None, 1, Fraction(3)),
}
"""Encodings by name; channels without a name (8UC3) are in order blue, green, red."""


def decode(name: str, numbers: NDArray[np.uint8] | NDArray[np.uint16], width: int, height: int) -> Bytes:
    """Return an image, shape (h, w) or (h, w, 3) in order blue, green, red.

    Args:
        name: one of `ENCODINGS`.
        numbers: its rows, shape (`Encoding.row_count`, numbers per row), in native byte order; those of nv24 with their
            padding.
        width: width of the image [px].
        height: height of the image [px].
    """
    encoding = ENCODINGS[name]
    rows = eight_bits(numbers)
    if name == 'nv24':
        return _bgr_from_nv24(rows, width, height)
    if name in ('nv12', 'nv21'):
        if height % 2:  # the last brightness row is repeated, as it has its own row of colours
            rows = np.insert(rows, height, rows[height - 1], axis=0)
    elif encoding.channels > 1:
        rows = rows.reshape(len(rows), -1, encoding.channels)
    if encoding.code is None:
        return rows
    decoded = cv2.cvtColor(np.ascontiguousarray(rows), encoding.code)
    return np.ascontiguousarray(decoded[:height, :width], dtype=np.uint8)


def eight_bits(numbers: NDArray[np.uint8] | NDArray[np.uint16]) -> Bytes:
    """Return numbers with 8 bits; 65535 becomes 255."""
    if numbers.dtype == np.uint8:
        return np.asarray(numbers, dtype=np.uint8)
    scaled = cv2.convertScaleAbs(np.ascontiguousarray(numbers), alpha=255.0 / 65535.0)
    return np.asarray(scaled, dtype=np.uint8).reshape(numbers.shape)


def _bgr_from_nv24(rows: Bytes, width: int, height: int) -> Bytes:
    """Convert a brightness for each pixel, then U and V for each pixel; OpenCV has no code for it."""
    y, colours = rows[:height, :width], rows[height:].reshape(height, -1)[:, : 2 * width]
    # At twice the size, each U and V of 4:2:0 belongs to one pixel.
    packed = np.vstack([np.repeat(np.repeat(y, 2, axis=0), 2, axis=1), colours])
    return np.ascontiguousarray(cv2.cvtColor(packed, cv2.COLOR_YUV2BGR_NV12)[::2, ::2], dtype=np.uint8)
