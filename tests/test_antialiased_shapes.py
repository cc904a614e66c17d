import math

import numpy as np
import pytest
from antialiased_shapes import coverage, ellipse_intervals, polygon_intervals

SIZE = (60, 50)


@pytest.mark.parametrize('blur', [0.0, 0.5, 1.5])
def test_area_and_centroid_are_those_of_the_ellipse(blur):
    covered = coverage(ellipse_intervals((30.3, 24.6), (15.0, 9.0), 0.4), SIZE, blur)
    y, x = np.indices(covered.shape)
    assert covered.sum() == pytest.approx(math.pi * 15 * 9, rel=1e-4)
    assert (covered * x).sum() / covered.sum() == pytest.approx(30.3, abs=1e-3)
    assert (covered * y).sum() / covered.sum() == pytest.approx(24.6, abs=1e-3)


def test_a_half_covered_pixel_is_half_covered():
    covered = coverage(polygon_intervals([[10, 10.25], [20.5, 10.25], [20.5, 20], [10, 20]]), SIZE)
    np.testing.assert_allclose(covered[10, 15], 0.25, atol=1e-9)
    np.testing.assert_allclose(covered[15, [9, 10, 15, 20, 21]], [0.0, 0.5, 1.0, 1.0, 0.0], atol=1e-9)


def test_area_of_a_turned_rectangle():
    c, s = math.cos(0.3), math.sin(0.3)
    corners = [(30 + c * x - s * y, 25 + s * x + c * y) for x, y in ((-10, -6), (10, -6), (10, 6), (-10, 6))]
    covered = coverage(polygon_intervals(corners), SIZE)
    assert covered.sum() == pytest.approx(240.0, rel=1e-3)
