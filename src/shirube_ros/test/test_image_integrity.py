"""Encoded images that were cut off are told from whole ones."""

import cv2
import numpy as np
import pytest

from shirube_ros.camera.image import is_jpeg_or_png, is_truncated

PIXELS = np.random.default_rng(1).integers(0, 256, (60, 80), dtype=np.uint8)


@pytest.mark.parametrize('suffix', ['.jpg', '.png'])
def test_a_whole_file_is_whole_and_a_cut_one_is_not(suffix):
    data = cv2.imencode(suffix, PIXELS)[1].ravel()
    padded = np.concatenate([data, np.zeros(100, np.uint8)])
    assert is_jpeg_or_png(data)
    assert [is_truncated(each) for each in (data, padded, data[:-20], data[:30])] == [
        False,
        False,
        True,
        True,
    ]


def test_of_other_kinds_nothing_is_known():
    data = cv2.imencode('.pgm', PIXELS)[1].ravel()[:50]
    assert (is_jpeg_or_png(data), is_truncated(data)) == (False, False)
    assert not is_truncated(data[:0])
