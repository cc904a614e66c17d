"""Dots of several views merged without duplicates, and levels of a map that do not overlap."""

import itertools

import numpy as np
import pytest

from floor_localizer.core.dots import FloorPoints, arrange_levels, level_at, merge_points, transform_points
from floor_localizer.core.errors import FloorLocalizerError
from shirube_core.geometry import SE2

NOTHING = FloorPoints(np.empty((0, 2)), np.empty(0))
STEP = SE2(0.3, -0.4, 0.7)


@pytest.fixture
def points():
    rng = np.random.default_rng(0)
    return FloorPoints(rng.uniform(-0.5, 0.5, (12, 2)), np.full(12, 1e-4))


def test_moved_points_stay_where_they_are_on_the_floor(points):
    T_map_old = SE2(1.0, 2.0, 0.3)
    T_map_new = T_map_old @ STEP.inverse()
    moved = transform_points(points, STEP, 0.05)
    expected = T_map_old.transform(points.points)
    np.testing.assert_allclose(T_map_new.transform(moved.points), expected, atol=1e-12)


def test_odometry_increases_sigmas_with_the_distance_driven(points):
    moved = [transform_points(points, SE2(distance, 0.0, 0.0), 0.05) for distance in (0.0, 0.1, 1.0)]
    sigmas = [each.sigmas[0] for each in moved]
    assert sigmas[0] == pytest.approx(1e-4)
    assert sigmas == sorted(sigmas)
    assert transform_points(points, STEP, 0.0).sigmas == pytest.approx(points.sigmas)


def test_merging_keeps_each_dot_once_those_of_the_second_first(points):
    again = FloorPoints(points.points + 1e-4, points.sigmas)
    others = FloorPoints(np.add(points.points, (2.0, 0.0)), points.sigmas * 2.0)
    for first, second, kept in (
        (points, NOTHING, [points]), (NOTHING, points, [points]),
        (points, again, [again]), (points, others, [others, points]),
    ):  # fmt: skip
        merged = merge_points(first, second)
        np.testing.assert_array_equal(merged.points, np.vstack([each.points for each in kept]))
        np.testing.assert_array_equal(merged.sigmas, np.concatenate([each.sigmas for each in kept]))


CORNERS = [(-3.5, 2.0, 7.1, 9.0), (0.0, 0.0, 12.0, 4.0), (100.0, -80.0, 101.0, -70.0)]
LEVELS = arrange_levels(['cellar', 'ground', 'roof'], CORNERS)


def test_levels_do_not_overlap():
    for one, other in itertools.combinations(LEVELS, 2):
        assert np.max([np.subtract(other.lower, one.upper), np.subtract(one.lower, other.upper)]) >= 1.0


def test_corners_are_those_of_the_floor_in_its_own_frame_and_poses_come_back():
    pose = SE2(1.25, 3.5, 2.0)
    for level, corners in zip(LEVELS, CORNERS, strict=True):
        lower, upper = (level.to_level(SE2(*corner, 0.0)) for corner in (level.lower, level.upper))
        assert (lower.x, lower.y, upper.x, upper.y) == pytest.approx(corners)
        assert level.to_level(level.to_map(pose)) == pose
        assert level_at(LEVELS, *np.mean([level.lower, level.upper], axis=0)) == level
        # Between levels, a point is on the nearest.
        assert level_at(LEVELS, level.lower[0] - 0.1, level.lower[1] - 0.1) == level
    assert level_at((), 1.0, 2.0) is None


def test_levels_too_large_for_single_precision_are_rejected():
    with pytest.raises(FloorLocalizerError, match='make several maps'):
        arrange_levels(['a', 'b'], [(0.0, 0.0, 700.0, 10.0)] * 2)
