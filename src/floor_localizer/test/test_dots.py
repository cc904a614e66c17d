"""Points of several views: transformed by odometry, without duplicates."""

import numpy as np
import pytest

from floor_localizer.core.dots import FloorPoints, merge_points, transform_points
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
    np.testing.assert_allclose(
        T_map_new.transform(moved.points), T_map_old.transform(points.points), atol=1e-12
    )


def test_odometry_increases_sigmas_with_the_distance_driven(points):
    sigmas = [
        transform_points(points, SE2(distance, 0.0, 0.0), 0.05).sigmas[0] for distance in (0.0, 0.1, 1.0)
    ]
    assert sigmas[0] == pytest.approx(1e-4)
    assert sigmas == sorted(sigmas)
    assert transform_points(points, STEP, 0.0).sigmas == pytest.approx(points.sigmas)


def test_merging_with_nothing_changes_nothing(points):
    for merged in (merge_points(points, NOTHING), merge_points(NOTHING, points)):
        np.testing.assert_array_equal(merged.points, points.points)
        np.testing.assert_array_equal(merged.sigmas, points.sigmas)


def test_merging_with_itself_keeps_each_dot_once(points):
    again = FloorPoints(points.points + 1e-4, points.sigmas)
    merged = merge_points(points, again)
    np.testing.assert_array_equal(merged.points, again.points)


def test_different_dots_are_all_kept_those_of_the_second_first(points):
    others = FloorPoints(np.add(points.points, (2.0, 0.0)), points.sigmas * 2.0)
    merged = merge_points(points, others)
    np.testing.assert_array_equal(merged.points, np.vstack([others.points, points.points]))
    np.testing.assert_array_equal(merged.sigmas, np.concatenate([others.sigmas, points.sigmas]))
