"""The debug image shows matched dots green and the others red."""

import numpy as np
import pytest
from localizer_results import a_fix, no_fix

from floor_localizer.localization.visualization import debug_picture

GRAY = np.full((235, 235), 128, dtype=np.uint8)


def colours_around(picture: np.ndarray, pixel: tuple[int, int]) -> set[str]:
    u, v = pixel
    patch = picture[v - 10 : v + 11, u - 10 : u + 11].astype(int)
    blue, green, red = patch[..., 0], patch[..., 1], patch[..., 2]
    names = set()
    if (green - np.maximum(red, blue)).max() > 80:
        names.add('green')
    if (red - np.maximum(green, blue)).max() > 80:
        names.add('red')
    return names


@pytest.mark.parametrize('pixels', [GRAY, np.dstack([GRAY] * 3)])
def test_rings_show_matched_and_unmatched_dots_and_cover_none(pixels):
    before = pixels.copy()
    picture = debug_picture(pixels, a_fix())
    assert picture.shape == (235, 235, 3)
    assert colours_around(picture, (30, 40)) == {'green'}
    assert colours_around(picture, (200, 60)) == {'red'}
    assert colours_around(picture, (100, 150)) == set()
    np.testing.assert_array_equal(pixels, before)
    np.testing.assert_array_equal(picture[38:43, 28:33], np.full((5, 5, 3), 128))


def test_without_a_fix_all_dots_are_red():
    picture = debug_picture(GRAY, no_fix())
    assert colours_around(picture, (117, 117)) == {'red'}
