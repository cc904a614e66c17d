import math

import numpy as np
import pytest
from antialiased_shapes import photograph
from seen_shapes import box, ellipse_photo, hide, polygon_light, polygon_photo, sides_of, turned_rectangle

BAR = turned_rectangle((50, 45), 80.0, 20.0, 0.2)


def _longest(sides):
    return np.sort(np.hypot(*(sides.ends[:, 1] - sides.ends[:, 0]).T))[::-1]


def test_line_segments_of_a_rectangle_have_consistent_variances():
    normal = np.array([-math.sin(0.2), math.cos(0.2)])
    ratios = []
    for seed in range(20):
        sides = sides_of(polygon_photo(BAR, seed=seed))
        steps = sides.ends[:, 1] - sides.ends[:, 0]
        long = np.hypot(*steps.T) > 60
        assert long.sum() == 2
        offsets = np.abs((sides.ends[long].mean(axis=1) - [50, 45]) @ normal) - 10.0
        assert np.abs(offsets).max() < 0.1
        ratios += list(offsets**2 / sides.variances[long, 0])
    assert 0.2 < math.sqrt(np.mean(ratios)) < 2.0


def test_the_bright_side_is_on_the_right():
    sides = sides_of(polygon_photo(BAR))
    steps = sides.ends[:, 1] - sides.ends[:, 0]
    right = np.column_stack([-steps[:, 1], steps[:, 0]])
    assert (np.sum(right * (sides.ends.mean(axis=1) - [50, 45]), axis=1) > 0.0).all()


def test_runs_on_both_sides_of_a_gap_are_joined_and_kept():
    sides = sides_of(photograph(hide(polygon_light(BAR), 130.0, box(42, -5, 54, 95)), 1.0))
    assert (_longest(sides)[:2] > 70).all()
    assert np.sum((_longest(sides) > 25) & (_longest(sides) < 45)) >= 4
    joined = np.hypot(*(sides.ends[:, 1] - sides.ends[:, 0]).T) > 70
    assert (sides.support[joined] < 69).all()


def test_a_wide_gap_is_not_joined():
    light = polygon_light(BAR)
    light[:, 25:75] = 120.0
    assert _longest(sides_of(photograph(light, 1.0), side_gap_max=0.3))[0] < 55


def test_a_large_circle_has_no_sides():
    assert len(sides_of(ellipse_photo((50, 45), (38.0, 38.0), 0.0, noise=1.0))) <= 2


@pytest.mark.parametrize('blur', [0.3, 1.0, 2.0])
def test_round_corners_do_not_cost_the_sides(blur):
    sides = sides_of(polygon_photo(turned_rectangle((50, 45), 40.0, 30.0, 0.1), blur=blur, noise=1.0))
    assert np.sum(_longest(sides) > 20) >= 4
