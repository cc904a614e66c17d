import numpy as np
import pytest
from floor_views import random_floor

from floor_localizer.core.dots import DotMap
from floor_localizer.core.errors import FloorLocalizerError
from floor_localizer.core.survey.map_comparison import compare
from shirube_core.geometry import SE2

MOTION = SE2(3.0, -2.0, 2.5)


@pytest.mark.parametrize('scale', [1.0, 1.002, 0.996])
def test_a_moved_map_is_the_same_map_and_its_scale_is_estimated(floor, scale):
    moved = DotMap(scale * MOTION.inverse().transform(floor.points), floor.diameters)
    found = compare(floor, moved)
    assert abs(found.scale - scale) < 1e-5
    np.testing.assert_array_equal(found.pairs[:, 0], found.pairs[:, 1])
    assert len(found.pairs) == len(floor)
    if scale == 1.0:
        assert found.T_first_second.distance_to(MOTION) < 1e-6
        assert abs(found.T_first_second.yaw_to(MOTION)) < 1e-6
        assert found.rms < 1e-6
        assert len(found.missing) == len(found.extra) == found.outside == 0


def test_noise_is_reported_as_rms(floor):
    noise = np.random.default_rng(1).normal(0.0, 0.0001, floor.points.shape)
    found = compare(floor, DotMap(floor.points + noise, floor.diameters))
    np.testing.assert_allclose(found.rms, 0.0001 * np.sqrt(2.0), rtol=0.05)


def test_missing_and_extra_dots_are_named(floor):
    inside = np.flatnonzero((np.abs(floor.points - (0.45, 0.3)) < (0.35, 0.2)).all(axis=1))[:30]
    less = DotMap(np.delete(floor.points, inside, axis=0), np.delete(floor.diameters, inside))
    found = compare(floor, less)
    assert set(found.missing) == set(inside)
    assert set(compare(less, floor).extra) == set(inside)


def test_dots_beyond_the_other_map_are_outside(floor):
    left = floor.points[:, 0] < 0.5
    found = compare(DotMap(floor.points[left], floor.diameters[left]), floor)
    assert len(found.missing) == 0
    assert found.outside > 0.9 * (~left).sum()


@pytest.mark.newest_set_only
def test_maps_of_different_floors_are_refused(floor):
    with pytest.raises(FloorLocalizerError, match='the maps do not overlap'):
        compare(floor, random_floor(9))
