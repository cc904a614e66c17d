"""Conversion of image messages to arrays and back, copying only where needed."""

from array import array
from dataclasses import dataclass
from fractions import Fraction

import cv2
import numpy as np
from numpy.typing import NDArray
from sensor_msgs.msg import CompressedImage, Image
from std_msgs.msg import Header

from shirube_ros.errors import ImageError

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


_END_MARKERS = {b'\xff\xd8': b'\xff\xd9', b'\x89P': b'IEND'}
"""End marker by the first bytes, for JPEG and PNG."""
_SEARCHED_BYTES = 1024
"""Number of last bytes that are searched, since cameras pad the end of JPEG data [byte]."""


def is_truncated(data: NDArray[np.uint8]) -> bool:
    """Return whether a JPEG or PNG, shape (n,), lacks its end marker; False for other formats."""
    end = _END_MARKERS.get(data[:2].tobytes())
    return end is not None and end not in data[-_SEARCHED_BYTES:].tobytes()


_REMEDY = 'set the camera driver to mono8 or bgr8'


def array_from_image(message: Image, topic: str) -> NDArray[np.uint8]:
    """Return an image as an array; mono8 and bgr8 share the message's memory if that is writeable.

    Bags return read-only memory. A read-only array is another type for numba kernels, which would all be compiled a
    second time for it.

    Returns:
        array, C-contiguous, writeable, shape (h, w) for grey, shape (h, w, 3) in order blue, green, red otherwise.

    Raises:
        ImageError: an encoding that is neither grey, colour, Bayer nor YUV, an empty image, or data that does not match
            size and step.
    """
    encoding = ENCODINGS.get(message.encoding)
    if encoding is None:
        raise ImageError(f'{topic} has the encoding {message.encoding!r}; {_REMEDY}')
    height, width, step = message.height, message.width, message.step
    if height == 0 or width == 0:
        raise ImageError(f'{topic} is empty, {width} x {height} px; check the camera driver')
    columns, count = encoding.row_bytes(width), encoding.row_count(height)
    if count > height and len(message.data) == columns * count:
        step = columns  # planes without padding; drivers differ in what they call a step
    if step < columns:
        raise ImageError(
            f'{topic} has rows of {step} bytes (step), {width} px of {message.encoding} need'
            f' {columns}; correct step in the camera driver'
        )
    if message.encoding == 'nv24':
        columns = step  # a row of colours is as long as two of brightness, with padding
    if len(message.data) < step * (count - 1) + columns:
        raise ImageError(
            f'{topic} is truncated, {width} x {height} px with step {step} need {step * count} bytes;'
            ' check the camera driver and the network'
        )
    kind = np.dtype(f'{">" if message.is_bigendian else "<"}u{encoding.bits // 8}')
    shape, strides = (count, columns // kind.itemsize), (step, kind.itemsize)
    numbers: NDArray[np.uint8] = np.ndarray(shape, kind, buffer=message.data, strides=strides)
    pixels = decode(message.encoding, numbers.astype(kind.newbyteorder('='), copy=False), width, height)
    return np.require(pixels, requirements=('C', 'W'))


def array_from_compressed_image(message: CompressedImage, topic: str) -> NDArray[np.uint8]:
    """Decode a JPEG or PNG image, grey, colour or the mosaic of a Bayer sensor.

    Returns:
        array, C-contiguous, shape (h, w) for grey, shape (h, w, 3) in order blue, green, red otherwise.

    Raises:
        ImageError: truncated data, or no image.
    """
    data = np.frombuffer(message.data, dtype=np.uint8)
    if data[:2].tobytes() not in _END_MARKERS:
        raise ImageError(f'{topic} is neither JPEG nor PNG (format {message.format!r}); send jpeg')
    if is_truncated(data):
        raise ImageError(f'{topic} is truncated; check the camera driver and the network')
    pixels = decode_file(data)
    if pixels is None:
        raise ImageError(f'{topic} cannot be decoded; check the camera driver and the network')
    # image_transport writes the encoding of the raw image first, and compresses a mosaic as if it were grey.
    encoding = message.format.partition(';')[0].strip()
    if encoding.startswith('bayer_') and encoding in ENCODINGS and pixels.ndim == 2:
        return decode(encoding, pixels, pixels.shape[1], pixels.shape[0])
    return pixels


def decode_file(data: NDArray[np.uint8]) -> NDArray[np.uint8] | None:
    """Decode the content of an image file, shape (n,), to 8-bit grey or BGR without alpha; None if it is no image."""
    try:
        pixels = cv2.imdecode(data, cv2.IMREAD_UNCHANGED) if len(data) else None
    except cv2.error:
        pixels = None
    if pixels is None or pixels.dtype not in (np.uint8, np.uint16):
        return None
    eight = eight_bits(pixels)
    if eight.ndim == 3 and eight.shape[2] == 4:
        return np.asarray(cv2.cvtColor(eight, cv2.COLOR_BGRA2BGR), dtype=np.uint8)
    return eight


def to_grey(pixels: NDArray[np.uint8]) -> NDArray[np.uint8]:
    """Convert an image, grey of shape (h, w) or BGR of shape (h, w, 3), to grey, shape (h, w)."""
    return pixels if pixels.ndim == 2 else np.asarray(cv2.cvtColor(pixels, cv2.COLOR_BGR2GRAY), dtype=np.uint8)


def image_from_array(pixels: NDArray[np.uint8], header: Header) -> Image:
    """Return a mono8 or bgr8 message of pixels, shape (h, w) gray or (h, w, 3) in order blue, green, red."""
    height, width = pixels.shape[:2]
    channels = 1 if pixels.ndim == 2 else 3
    # Assigning a numpy array to Image.data copies it element by element in Python; an array.array does not.
    data = array('B')
    data.frombytes(np.ascontiguousarray(pixels).data.cast('B'))
    return Image(
        header=header,
        height=height,
        width=width,
        encoding='mono8' if channels == 1 else 'bgr8',
        step=width * channels,
        data=data,
    )


_TYPES: dict[str, np.dtype[np.uint16] | np.dtype[np.float32]] = {
    '16UC1': np.dtype(np.uint16),
    'mono16': np.dtype(np.uint16),
    '32FC1': np.dtype(np.float32),
}
_MILLIMETRE = 1e-3


def depth_from_image(message: Image, topic: str) -> NDArray[np.float32]:
    """Return a depth image, shape (h, w) [m], NaN where there is no depth.

    The message is 32FC1 in metres, or 16UC1 in millimetres with 0 for no depth.

    Raises:
        ImageError: unsupported encoding, or data that does not match the size.
    """
    kind = _TYPES.get(message.encoding)
    if kind is None:
        raise ImageError(f'{topic} has the encoding {message.encoding!r}; send 32FC1 (metres) or 16UC1 (millimetres)')
    kind = kind.newbyteorder('>' if message.is_bigendian else '<')
    height, width, step = message.height, message.width, message.step
    if height == 0 or width == 0 or step < width * kind.itemsize:
        raise ImageError(f'{topic} is {width} x {height} px with rows of {step} bytes; check the camera driver')
    if len(message.data) < step * (height - 1) + width * kind.itemsize:
        raise ImageError(f'{topic} is truncated; check the camera driver and the network')
    raw: NDArray[np.generic] = np.ndarray((height, width), kind, buffer=message.data, strides=(step, kind.itemsize))
    if kind.kind == 'f':
        return np.ascontiguousarray(raw, dtype=np.float32)
    depth = raw.astype(np.float32) * np.float32(_MILLIMETRE)
    depth[depth == 0.0] = np.nan
    return depth
