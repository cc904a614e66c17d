"""Every encoding of sensor_msgs from a known picture, built here byte by byte, back to the picture."""

from array import array

import cv2
import numpy as np
import pytest
from sensor_msgs.msg import CompressedImage, Image

from shirube_ros.camera.image import ENCODINGS, array_from_compressed_image, array_from_image, depth_from_image

# As image_encodings.hpp lists them, without those of other numbers than images hold.
NAMES = [
    *('8UC1', '8UC3', '8UC4', '16UC1', '16UC3', '16UC4'),
    *(f'{name}{bits}' for name in ('mono', 'rgb', 'bgr', 'rgba', 'bgra') for bits in (8, 16)),
    *(f'bayer_{name}{bits}' for name in ('rggb', 'bggr', 'gbrg', 'grbg') for bits in (8, 16)),
    *('uyvy', 'yuv422', 'yuyv', 'yuv422_yuy2', 'nv12', 'nv21', 'nv24'),
]
SIZES = [(48, 64), (47, 63)]
ORDERS = {'bgr': (0, 1, 2), 'rgb': (2, 1, 0), 'bgra': (0, 1, 2, 3), 'rgba': (2, 1, 0, 3)}
ORDERS |= {'mono': (0,), '8UC1': (0,), '16UC1': (0,), '8UC3': (0, 1, 2), '8UC4': (0, 1, 2, 3)}
ORDERS |= {'16UC3': (0, 1, 2), '16UC4': (0, 1, 2, 3)}


def picture(height: int, width: int) -> np.ndarray:
    """Return smooth colours, shape (h, w, 3) blue, green, red, that differ in each corner."""
    y, x = np.mgrid[:height, :width] / (height, width)[0]
    return np.dstack([60 + 120 * x, 200 - 110 * y, 40 + 80 * x * y + 60 * y]).astype(np.uint8)


def yuv(bgr: np.ndarray) -> tuple[np.ndarray, ...]:
    """Return Y, U and V by ITU-R BT.601, 16 to 235."""
    b, g, r = (bgr[..., i] / 255.0 for i in range(3))
    y = 16.0 + 65.481 * r + 128.553 * g + 24.966 * b
    u = 128.0 - 37.797 * r - 74.203 * g + 112.0 * b
    v = 128.0 + 112.0 * r - 93.786 * g - 18.214 * b
    return tuple(np.rint(each).astype(np.uint8) for each in (y, u, v))


def padded_even(plane: np.ndarray) -> np.ndarray:
    return np.pad(plane, [(0, plane.shape[0] % 2), (0, plane.shape[1] % 2)], mode='edge')


def rows_of(name: str, bgr: np.ndarray) -> np.ndarray:
    """Return the numbers of the rows of an image, shape (rows, numbers)."""
    height, width = bgr.shape[:2]
    if name.startswith('bayer'):
        colours = {'b': 0, 'g': 1, 'r': 2}
        mosaic = np.empty((height, width), np.uint8)
        for i, letter in enumerate(name[6:10]):
            row, column = divmod(i, 2)
            mosaic[row::2, column::2] = bgr[row::2, column::2, colours[letter]]
        return mosaic
    if name in ('uyvy', 'yuv422', 'yuyv', 'yuv422_yuy2'):
        y, u, v = (np.pad(plane, [(0, 0), (0, width % 2)], mode='edge') for plane in yuv(bgr))
        pairs = (u[:, ::2], y[:, ::2], v[:, ::2], y[:, 1::2])
        if name not in ('uyvy', 'yuv422'):
            pairs = (y[:, ::2], u[:, ::2], y[:, 1::2], v[:, ::2])
        return np.stack(pairs, axis=2).reshape(height, -1)
    if name in ('nv12', 'nv21'):
        y, u, v = (padded_even(plane) for plane in yuv(bgr))
        first, second = (u, v) if name == 'nv12' else (v, u)
        colour = np.stack([first[::2, ::2], second[::2, ::2]], axis=2).reshape(len(u) // 2, -1)
        return np.vstack([y[:height], colour])
    y, u, v = yuv(bgr)  # nv24
    return np.vstack([y, np.stack([u, v], axis=2).reshape(2 * height, width)])


def message_of(name: str, bgr: np.ndarray, padding: int = 0, *, big_endian: bool = False) -> Image:
    height, width = bgr.shape[:2]
    order = ORDERS.get(name) or ORDERS.get(name.rstrip('0123456789'))
    if order is not None:
        numbers = np.dstack([bgr, np.full((height, width), 7, np.uint8)])[..., list(order)].reshape(height, -1)
    else:
        numbers = rows_of(name, bgr)
    if '16' in name:
        numbers = (numbers.astype(np.uint16) * 257).astype('>u2' if big_endian else '<u2')
    raw = np.ascontiguousarray(numbers).view(np.uint8)
    if name == 'nv24' and padding:
        # A row of U and V has the padding of two rows.
        colour = np.pad(raw[height:].reshape(height, -1), [(0, 0), (0, 2 * padding)])
        raw = np.vstack([np.pad(raw[:height], [(0, 0), (0, padding)]), colour.reshape(2 * height, -1)])
    else:
        raw = np.pad(raw, [(0, 0), (0, padding)], constant_values=99)
    return Image(
        height=height, width=width, encoding=name, step=raw.shape[1],
        is_bigendian=int(big_endian), data=array('B', raw.tobytes()),
    )  # fmt: skip


def check(name: str, found: np.ndarray, bgr: np.ndarray) -> None:
    assert found.dtype == np.uint8
    assert found.flags.c_contiguous
    assert found.flags.writeable
    if ORDERS.get(name) == (0,) or name.startswith('mono'):
        np.testing.assert_array_equal(found, bgr[..., 0])
        return
    # The mosaic has a third of the colours, and YUV 4:2:0 a quarter.
    tolerance = 3 if name == 'nv24' else 8 if name[:2] in ('nv', 'yu', 'uy', 'ba') else 0
    assert found.shape == bgr.shape
    inner = np.s_[2:-2, 2:-2] if name.startswith('bayer') else np.s_[:, :]
    assert np.abs(found[inner].astype(int) - bgr[inner].astype(int)).max() <= tolerance


def test_no_encoding_is_missing() -> None:
    assert set(ENCODINGS) == set(NAMES)


@pytest.mark.parametrize('size', SIZES)
@pytest.mark.parametrize('name', NAMES)
def test_each_encoding_gives_the_picture(name: str, size: tuple[int, int]) -> None:
    bgr = picture(*size)
    for padding in (0, 6):
        check(name, array_from_image(message_of(name, bgr, padding), 't'), bgr)
    if '16' in name:
        check(name, array_from_image(message_of(name, bgr, big_endian=True), 't'), bgr)
    # Two numbers a pixel is how image_encodings counts some planes.
    message = message_of(name, bgr)
    if name.startswith('nv') and size[1] % 2 == 0:
        message.step *= 2
        check(name, array_from_image(message, 't'), bgr)


def test_a_compressed_mosaic_keeps_its_colours() -> None:
    bgr = picture(18, 24)
    data = cv2.imencode('.png', rows_of('bayer_gbrg8', bgr))[1].tobytes()
    message = CompressedImage(format='bayer_gbrg8; png compressed ', data=array('B', data))
    check('bayer_gbrg8', array_from_compressed_image(message, 't'), bgr)


def test_a_big_endian_depth_image_has_the_same_depth() -> None:
    depth = np.array([[1000, 0, 2500]], np.uint16)
    data = array('B', depth.astype('>u2').tobytes())
    message = Image(height=1, width=3, encoding='16UC1', step=6, is_bigendian=1, data=data)
    np.testing.assert_allclose(depth_from_image(message, 't'), [[1.0, np.nan, 2.5]])
