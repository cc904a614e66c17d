"""Conversion of image messages to arrays and back, copying only where needed."""

from array import array

import cv2
import numpy as np
from numpy.typing import NDArray
from sensor_msgs.msg import CompressedImage, Image
from std_msgs.msg import Header

from shirube_ros.camera.encodings import ENCODINGS, decode, eight_bits
from shirube_ros.errors import ImageError

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
