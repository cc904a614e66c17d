import math

import numpy as np
import pytest
from antialiased_shapes import coverage, ellipse_intervals, polygon_intervals

SIZE = (60, 50)


C, S = math.cos(0.4), math.sin(0.4)
TURNED = [(30.3 + C * x - S * y, 24.6 + S * x + C * y) for x, y in ((-10, -6), (10, -6), (10, 6), (-10, 6))]


@pytest.mark.parametrize('blur', [0.0, 0.5, 1.5])
@pytest.mark.parametrize(
    ('shape', 'area'),
    [(ellipse_intervals((30.3, 24.6), (15, 9), 0.4), math.pi * 15 * 9), (polygon_intervals(TURNED), 240.0)],
)
def test_area_and_centroid_are_those_of_the_shape(shape, area, blur):
    covered = coverage(shape, SIZE, blur)
    assert covered.sum() == pytest.approx(area, rel=1e-3)
    y, x = np.indices(covered.shape)
    assert np.average([x, y], axis=(1, 2), weights=[covered] * 2) == pytest.approx((30.3, 24.6), abs=2e-3)


def test_a_half_covered_pixel_is_half_covered():
    covered = coverage(polygon_intervals([[10, 10.25], [20.5, 10.25], [20.5, 20], [10, 20]]), SIZE)
    np.testing.assert_allclose(covered[10, 15], 0.25, atol=1e-9)
    np.testing.assert_allclose(covered[15, [9, 10, 15, 20, 21]], [0.0, 0.5, 1.0, 1.0, 0.0], atol=1e-9)
