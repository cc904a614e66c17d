import math

import cv2
import numpy as np
import pytest

from stereo_landmark.core.primitives.ellipse_fit import (
    ellipse_point,
    fit_ellipse,
    foot_point,
    normal_jacobian_row,
    perimeter,
)


def _points(parameters, begin=0.0, end=2 * math.pi, count=40):
    return np.array([ellipse_point(parameters, t)[:2] for t in np.linspace(begin, end, count)])


@pytest.mark.parametrize('tilt', [0.0, 0.3, 1.5, -0.8, -1.5])
@pytest.mark.parametrize('axes', [(30.0, 12.0), (9.0, 8.0), (200.0, 50.0)])
def test_exact_points_give_the_ellipse_back(axes, tilt):
    truth = np.array([400.0, 321.0, *axes, tilt])
    fitted = np.empty(5)
    assert fit_ellipse(_points(truth, 0.2, 3.4), fitted)
    np.testing.assert_allclose(fitted[:4], truth[:4], atol=1e-4)
    assert math.remainder(fitted[4] - tilt, math.pi) == pytest.approx(0.0, abs=1e-5)


def test_agrees_with_a_second_implementation_on_noisy_points():
    points = _points(np.array([400.0, 321.0, 30.0, 18.0, 0.4]))
    points += np.random.default_rng(0).normal(0, 0.3, (40, 2))
    fitted = np.empty(5)
    assert fit_ellipse(points, fitted)
    centre, size, _ = cv2.fitEllipseDirect(points.astype(np.float32))
    np.testing.assert_allclose(fitted[:2], centre, atol=0.02)
    np.testing.assert_allclose(fitted[2:4], 0.5 * np.sort(size)[::-1], atol=0.02)


def test_points_on_a_line_are_no_ellipse():
    x = np.linspace(0.0, 50.0, 20)
    assert not fit_ellipse(np.column_stack([x, 2.0 * x]), np.empty(5))


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
