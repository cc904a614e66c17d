import numpy as np
from place_scenes import RIG, panel, teach, view

from stereo_landmark.core.place.place_locator import PlaceLocator
from stereo_landmark.core.settings import PlaceSettings
from stereo_landmark.core.teaching.geometry_hints import (
    check_geometry,
    count_distinct_points,
    horizontal_extent,
    pose_sigmas,
)


def warnings(points, noise=0.1):
    """Return the warnings for points in front of the cameras."""
    taught = teach(points, noise, np.random.default_rng(1))
    seen = view(points, np.zeros(6), noise, np.random.default_rng(2))
    fix = PlaceLocator(RIG, PlaceSettings(position_sigma_max=10.0)).locate(seen, taught)
    return check_geometry(taught.positions, fix)


def test_many_points_far_apart_are_good():
    assert warnings(panel(3.0, 1.0, 16)) == []


def test_few_narrow_and_far_points_are_reported():
    assert any(line.startswith('too few points: 3') for line in warnings(panel(3.0, 1.0, 3)))
    assert any(line.startswith('too narrow') for line in warnings(panel(3.0, 0.2, 8)))
    far = warnings(panel(6.0, 0.1, 4, depth=0.02, seed=3))
    assert any(line.startswith('too shallow: at 6.') for line in far), far
    assert any('yaw has a standard deviation of' in line for line in far)


def test_rims_around_one_centre_are_one_spot():
    meters = panel(3.0, 1.0, 2, depth=0.0)
    rims = np.vstack([meters, meters + 0.001])
    assert any(
        line.startswith('too close together: 4 points at 2 distinct positions') for line in warnings(rims)
    )
    assert count_distinct_points(rims) == count_distinct_points(rims[::-1]) == 2
    assert count_distinct_points(panel(3.0, 1.0, 16)) == 16


def test_the_width_does_not_change_with_the_direction_of_the_wall():
    points = panel(depth=0.0)
    points[:2, 1] = -0.4, 0.4
    for angle in (0.0, 0.7, 2.0):
        cos, sin = np.cos(angle), np.sin(angle)
        turned = points @ np.array([[cos, sin, 0.0], [-sin, cos, 0.0], [0.0, 0.0, 1.0]])
        assert np.isclose(horizontal_extent(turned), 0.8)


def test_the_worst_direction_counts():
    points = panel()
    fix = PlaceLocator(RIG).locate(view(points, np.zeros(6), 0.1, np.random.default_rng(1)), teach(points))
    position, yaw = pose_sigmas(fix)
    assert position >= np.sqrt(np.diag(fix.covariance)[:2].max())
    assert yaw == np.sqrt(fix.covariance[3, 3])
