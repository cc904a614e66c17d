import math

import numpy as np
import pytest

from stereo_landmark.core.primitives.ellipse_fit import (
    ellipse_point,
    foot_point,
    normal_jacobian_row,
    perimeter,
)

ELLIPSE = np.array([50.0, 40.0, 30.0, 12.0, 0.7])


@pytest.mark.parametrize('t', np.linspace(0.1, 6.0, 7))
@pytest.mark.parametrize('distance', [-3.0, -0.5, 0.0, 4.0])
def test_foot_of_a_point_on_the_normal_is_where_it_starts(t, distance):
    _, _, a, b, _ = ELLIPSE
    x, y, nx, ny, speed = ellipse_point(np.array([0.0, 0.0, a, b, 0.0]), t)
    cos_t, sin_t, found_speed = foot_point(a, b, x + distance * nx, y + distance * ny)
    assert (cos_t, sin_t) == pytest.approx((math.cos(t), math.sin(t)), abs=2e-3)
    assert found_speed == pytest.approx(speed, rel=2e-3)


@pytest.mark.parametrize('t', np.linspace(0.1, 6.0, 7))
def test_normal_motion_is_what_differences_say(t):
    row = np.empty(5)
    normal_jacobian_row(ELLIPSE, t, row)
    x, y, nx, ny, _ = ellipse_point(ELLIPSE, t)
    for k in range(5):
        moved = ELLIPSE.copy()
        moved[k] += 1e-5
        mx, my = ellipse_point(moved, t)[:2]
        assert ((mx - x) * nx + (my - y) * ny) / 1e-5 == pytest.approx(row[k], abs=1e-3)


def test_perimeter_of_a_circle_and_of_a_flat_ellipse():
    assert perimeter(10.0, 10.0) == pytest.approx(20.0 * math.pi)
    t = np.linspace(0.0, 2 * math.pi, 100001)
    exact = np.sum(np.hypot(*np.diff([30 * np.cos(t), 6 * np.sin(t)], axis=1)))
    assert perimeter(30.0, 6.0) == pytest.approx(exact, rel=1e-4)
