"""Conversion of depth images in metres and in millimetres."""

import numpy as np
import pytest
from sensor_msgs.msg import Image

from shirube_ros.camera.image import depth_from_image
from shirube_ros.errors import ImageError


def image(pixels: np.ndarray, encoding: str, pad: int = 0) -> Image:
    rows = np.pad(pixels, ((0, 0), (0, pad)))
    return Image(
        height=pixels.shape[0],
        width=pixels.shape[1],
        encoding=encoding,
        step=rows.strides[0],
        data=rows.tobytes(),
    )


def test_metres_and_millimetres_say_the_same() -> None:
    metres = np.array([[1.0, np.nan, 2.5], [0.004, 3.0, 4.0]], dtype=np.float32)
    millimetres = np.array([[1000, 0, 2500], [4, 3000, 4000]], dtype=np.uint16)
    for pad in (0, 2):
        np.testing.assert_array_equal(depth_from_image(image(metres, '32FC1', pad), 'depth'), metres)
        np.testing.assert_allclose(depth_from_image(image(millimetres, '16UC1', pad), 'depth'), metres)


@pytest.mark.parametrize(
    ('change', 'words'),
    [
        ({'encoding': 'mono8'}, "encoding 'mono8'"),
        ({'is_bigendian': 1}, 'little endian'),
        ({'height': 9}, 'truncated'),
        ({'step': 5}, 'rows of 5 bytes'),
        ({'width': 0}, '0 x 2 px'),
    ],
)
def test_images_that_do_not_fit_are_refused(change: dict[str, object], words: str) -> None:
    message = image(np.ones((2, 3), dtype=np.float32), '32FC1')
    for name, value in change.items():
        setattr(message, name, value)
    with pytest.raises(ImageError, match=words):
        depth_from_image(message, 'depth')
