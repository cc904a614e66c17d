"""Levels of a map do not overlap, and poses are transformed there and back."""

import itertools

import pytest

from floor_localizer.core.errors import FloorLocalizerError
from floor_localizer.core.levels import arrange_levels, level_at
from shirube_core.geometry import SE2

CORNERS = [(-3.5, 2.0, 7.1, 9.0), (0.0, 0.0, 12.0, 4.0), (100.0, -80.0, 101.0, -70.0)]
LEVELS = arrange_levels(['cellar', 'ground', 'roof'], CORNERS)


def test_levels_do_not_overlap():
    for one, other in itertools.combinations(LEVELS, 2):
        gaps = [
            max(other.lower[axis] - one.upper[axis], one.lower[axis] - other.upper[axis]) for axis in range(2)
        ]
        assert max(gaps) >= 1.0


def test_corners_are_those_of_the_floor_in_its_own_frame():
    for level, corners in zip(LEVELS, CORNERS, strict=True):
        lower = level.to_level(SE2(*level.lower, 0.0))
        upper = level.to_level(SE2(*level.upper, 0.0))
        assert (lower.x, lower.y, upper.x, upper.y) == pytest.approx(corners)


def test_a_pose_comes_back_from_the_map():
    pose = SE2(1.25, 3.5, 2.0)
    for level in LEVELS:
        assert level.to_level(level.to_map(pose)) == pose


def test_a_point_is_on_the_level_that_contains_it_or_is_nearest():
    for level in LEVELS:
        middle = [(a + b) / 2.0 for a, b in zip(level.lower, level.upper, strict=True)]
        assert level_at(LEVELS, *middle) == level
        assert level_at(LEVELS, level.lower[0] - 0.1, level.lower[1] - 0.1) == level
    assert level_at((), 1.0, 2.0) is None


def test_levels_too_large_for_single_precision_are_rejected():
    with pytest.raises(FloorLocalizerError, match='make several maps'):
        arrange_levels(['a', 'b'], [(0.0, 0.0, 700.0, 10.0)] * 2)
