"""Image messages to arrays and back."""

from array import array
from collections.abc import Callable
from types import SimpleNamespace
from typing import cast

import cv2
import numpy as np
import pytest
from numba import typeof
from sensor_msgs.msg import CompressedImage, Image
from std_msgs.msg import Header

from shirube_ros.camera.image import array_from_compressed_image, array_from_image, depth_from_image, image_from_array
from shirube_ros.errors import ImageError

RNG = np.random.default_rng(5)
GRAY = RNG.integers(0, 256, (7, 5), dtype=np.uint8)
BGR = RNG.integers(0, 256, (7, 5, 3), dtype=np.uint8)
SMOOTH = cv2.GaussianBlur(RNG.integers(0, 256, (60, 80), dtype=np.uint8), (0, 0), 8)


def image(encoding: str, rows: np.ndarray, padding: int = 0) -> Image:
    """Build a message byte by byte, independent of the code under test."""
    flat = rows.reshape(rows.shape[0], -1).view(np.uint8)
    padded = np.pad(flat, ((0, 0), (0, padding)), constant_values=77)
    data = array('B', padded.tobytes())
    height, width = rows.shape[:2]
    return Image(height=height, width=width, encoding=encoding, step=padded.shape[1], data=data)


@pytest.mark.parametrize('pixels', [GRAY, BGR, BGR[::2, ::-1]])  # the last one is not contiguous
def test_arrays_come_back_from_messages(pixels: np.ndarray) -> None:
    message = image_from_array(pixels, Header(frame_id='camera'))
    assert message.header.frame_id == 'camera'
    np.testing.assert_array_equal(array_from_image(message, 'image_raw'), pixels)


@pytest.mark.parametrize('padding', [0, 3])
def test_every_encoding_gives_gray_or_bgr(padding: int) -> None:
    np.testing.assert_array_equal(array_from_image(image('mono8', GRAY, padding), 't'), GRAY)
    np.testing.assert_array_equal(array_from_image(image('bgr8', BGR, padding), 't'), BGR)
    np.testing.assert_array_equal(array_from_image(image('rgb8', BGR[..., ::-1], padding), 't'), BGR)


@pytest.mark.parametrize('pixels', [GRAY, BGR])
def test_kernels_get_the_same_type_from_a_bag_as_from_a_camera(pixels: np.ndarray) -> None:
    from_camera = image_from_array(pixels, Header())
    # As the reader of bags makes it.
    recorded = SimpleNamespace(
        encoding=from_camera.encoding,
        height=from_camera.height,
        width=from_camera.width,
        step=from_camera.step,
        is_bigendian=0,
        data=np.frombuffer(from_camera.data.tobytes(), np.uint8),
    )
    from_bag = array_from_image(cast(Image, recorded), 't')
    np.testing.assert_array_equal(from_bag, pixels)
    shown = array_from_image(from_camera, 't')
    assert typeof(from_bag) == typeof(shown)
    assert np.shares_memory(shown, np.frombuffer(from_camera.data, np.uint8))


def test_the_last_row_needs_no_padding() -> None:
    message = image('mono8', GRAY, padding=3)
    message.data = message.data[:-3]
    np.testing.assert_array_equal(array_from_image(message, 't'), GRAY)


@pytest.mark.parametrize(
    ('read', 'change', 'words'),
    [
        (array_from_image, {'encoding': '32FC1'}, r"front has the encoding '32FC1'; .* mono8 or bgr8"),
        (array_from_image, {'encoding': ''}, r"encoding ''"),
        (array_from_image, {'height': 0}, r'is empty, 5 x 0 px'),
        (array_from_image, {'step': 4}, r'rows of 4 bytes \(step\), 5 px of mono8 need 5'),
        (array_from_image, {'encoding': 'rgb8'}, r'5 px of rgb8 need 15'),
        (array_from_image, {'height': 8}, r'truncated, 5 x 8 px with step 5 need 40 bytes'),
        (array_from_image, {'data': array('B')}, r'truncated'),
        (depth_from_image, {'encoding': 'mono8'}, "encoding 'mono8'"),
        (depth_from_image, {'height': 9}, 'truncated'),
        (depth_from_image, {'step': 5}, 'rows of 5 bytes'),
        (depth_from_image, {'width': 0}, '0 x 2 px'),
    ],
)
def test_broken_images_are_refused_with_the_remedy(
    read: Callable[[Image, str], np.ndarray], change: dict[str, object], words: str
) -> None:
    depth = image('32FC1', np.ones((2, 3), np.float32))
    message = image('mono8', GRAY) if read is array_from_image else depth
    for name, value in change.items():
        setattr(message, name, value)
    with pytest.raises(ImageError, match=words):
        read(message, 'front')


def compressed(extension: str, pixels: np.ndarray, padding: bytes = b'') -> CompressedImage:
    data = cv2.imencode(extension, pixels)[1].tobytes() + padding
    return CompressedImage(format=extension, data=array('B', data))


def test_png_is_lossless_and_jpeg_close() -> None:
    np.testing.assert_array_equal(array_from_compressed_image(compressed('.png', BGR), 't'), BGR)
    np.testing.assert_array_equal(array_from_compressed_image(compressed('.png', GRAY), 't'), GRAY)
    for pixels in (GRAY, BGR):
        deep = compressed('.png', pixels.astype(np.uint16) * 257)
        np.testing.assert_array_equal(array_from_compressed_image(deep, 't'), pixels)
    translucent = compressed('.png', np.dstack([BGR, GRAY]))
    np.testing.assert_array_equal(array_from_compressed_image(translucent, 't'), BGR)
    decoded = array_from_compressed_image(compressed('.jpg', SMOOTH), 't')
    assert decoded.shape == SMOOTH.shape
    assert np.abs(decoded.astype(int) - SMOOTH).max() < 10


def test_a_jpeg_may_be_padded() -> None:
    padded = compressed('.jpg', SMOOTH, padding=bytes(500))
    assert array_from_compressed_image(padded, 't').shape == SMOOTH.shape


@pytest.mark.parametrize('extension', ['.png', '.jpg'])
@pytest.mark.parametrize('kept', [0, 1, 2, 10, 200, -10, -1])
def test_a_file_that_was_cut_off_is_refused(extension: str, kept: int) -> None:
    message = compressed(extension, SMOOTH)
    message.data = message.data[:kept]
    with pytest.raises(ImageError, match=r'truncated|neither JPEG nor PNG|cannot be decoded'):
        array_from_compressed_image(message, 't')


@pytest.mark.parametrize(
    ('message', 'words'),
    [
        (compressed('.bmp', GRAY), r'front is neither JPEG nor PNG'),
        (CompressedImage(data=array('B', b'\xff\xd8' + b'rubbish' * 9 + b'\xff\xd9')), 'cannot be decoded'),
    ],
)
def test_other_files_are_refused(message: CompressedImage, words: str) -> None:
    with pytest.raises(ImageError, match=words):
        array_from_compressed_image(message, 'front')


def test_metres_and_millimetres_say_the_same() -> None:
    metres = np.array([[1.0, np.nan, 2.5], [0.004, 3.0, 4.0]], dtype=np.float32)
    millimetres = np.array([[1000, 0, 2500], [4, 3000, 4000]], dtype=np.uint16)
    for pad in (0, 2):
        np.testing.assert_array_equal(depth_from_image(image('32FC1', metres, pad), 'depth'), metres)
        np.testing.assert_allclose(depth_from_image(image('16UC1', millimetres, pad), 'depth'), metres)
