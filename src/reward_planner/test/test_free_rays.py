"""Rays through voxels against rays cut at every face."""

from __future__ import annotations

import numpy as np
import pytest
from slow_voxels import voxels_on_the_way

from reward_planner.core.voxels.free_rays import ENDED, PASSED, mark_ends_passed, mark_passed

SHAPE = (32, 32, 10)


def passed_by(ends, origin, marks=None):
    """Traversed voxels by the code under test."""
    marks = np.zeros(SHAPE, dtype=np.uint8) if marks is None else marks
    passed = np.empty(marks.size, dtype=np.int32)
    flat = np.array([np.ravel_multi_index(end, SHAPE) for end in ends], dtype=np.int32)
    count = mark_passed(flat, np.array(origin), marks, passed, 0)
    assert len(set(passed[:count].tolist())) == count
    assert (np.flatnonzero(marks == PASSED) == np.sort(passed[:count])).all()
    return {tuple(int(i) for i in np.unravel_index(cell, SHAPE)) for cell in passed[:count]}


def by_the_book(ends, origin):
    """Traversed voxels by the reference implementation, within the window and without the ends."""
    way = [voxels_on_the_way(origin, np.array(end) + 0.5, 1.0, 0.0) - {end} for end in ends]
    return {v for v in set().union(*way) if 0 <= v[2] < SHAPE[2]}


@pytest.mark.parametrize('height', [4.3, -3.7, 14.2])
def test_rays_pass_the_voxels_that_they_cut(height):
    rng = np.random.default_rng(3)
    for _ in range(150):
        origin = (*rng.uniform(10.0, 22.0, 2), height + rng.uniform(-0.2, 0.2))
        end = tuple(int(rng.integers(0, n)) for n in SHAPE)
        assert passed_by([end], origin) == by_the_book([end], origin)


def test_many_rays_pass_what_each_of_them_passes():
    rng = np.random.default_rng(4)
    ends = [tuple(int(rng.integers(0, n)) for n in SHAPE) for _ in range(100)]
    origin = (15.3141, 16.8271, 4.2236)  # no ray meets an edge, where both neighbours would be right
    assert passed_by(ends, origin) == by_the_book(ends, origin)


def test_rays_along_an_axis_are_straight():
    assert passed_by([(20, 5, 3)], (15.5, 5.5, 3.5)) == {(x, 5, 3) for x in range(15, 20)}
    assert passed_by([(15, 5, 0)], (15.5, 5.5, 9.5)) == {(15, 5, z) for z in range(1, 10)}


def test_a_voxel_with_points_is_not_passed():
    marks = np.zeros(SHAPE, dtype=np.uint8)
    marks[17, 5, 3] = ENDED
    assert (17, 5, 3) not in passed_by([(20, 5, 3)], (15.5, 5.5, 3.5), marks)


def test_the_sensor_in_the_voxel_of_its_point_passes_nothing():
    assert passed_by([(15, 5, 3)], (15.2, 5.7, 3.1)) == set()


def test_open_ends_are_passed_unless_points_lie_there():
    marks, passed = np.zeros(SHAPE, dtype=np.uint8), np.empty(10, dtype=np.int32)
    marks.reshape(-1)[5] = ENDED
    assert mark_ends_passed(np.array([4, 5, 6], dtype=np.int32), marks, passed, 0) == 2
    assert passed[:2].tolist() == [4, 6]
