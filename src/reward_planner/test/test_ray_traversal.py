"""Rays through voxels against rays cut at every face."""

from __future__ import annotations

import numpy as np
import pytest
from slow_voxels import voxels_on_segment

from reward_planner.core.voxels.frame_kernels import HIT, TRAVERSED, mark_traversed, mark_traversed_exits

SHAPE = (32, 32, 10)


def traversed_by(ends, origin, marks=None):
    """Traversed voxels by the code under test."""
    marks = np.zeros(SHAPE, dtype=np.uint8) if marks is None else marks
    traversed = np.empty(marks.size, dtype=np.int32)
    flat = np.array([np.ravel_multi_index(end, SHAPE) for end in ends], dtype=np.int32)
    count = mark_traversed(flat, np.array(origin), marks, traversed, 0)
    assert len(set(traversed[:count].tolist())) == count
    assert (np.flatnonzero(marks == TRAVERSED) == np.sort(traversed[:count])).all()
    return {tuple(int(i) for i in np.unravel_index(cell, SHAPE)) for cell in traversed[:count]}


def reference_traversal(ends, origin):
    """Traversed voxels by the reference implementation, within the window and without the ends."""
    way = [voxels_on_segment(origin, np.array(end) + 0.5, 1.0, 0.0) - {end} for end in ends]
    return {v for v in set().union(*way) if 0 <= v[2] < SHAPE[2]}


@pytest.mark.parametrize('height', [4.3, -3.7, 14.2])
def test_rays_pass_the_voxels_that_they_cut(height):
    rng = np.random.default_rng(3)
    for _ in range(150):
        origin = (*rng.uniform(10.0, 22.0, 2), height + rng.uniform(-0.2, 0.2))
        end = tuple(int(rng.integers(0, n)) for n in SHAPE)
        assert traversed_by([end], origin) == reference_traversal([end], origin)


def test_many_rays_pass_what_each_of_them_passes():
    rng = np.random.default_rng(4)
    ends = [tuple(int(rng.integers(0, n)) for n in SHAPE) for _ in range(100)]
    origin = (15.3141, 16.8271, 4.2236)  # no ray meets an edge, where both neighbours would be right
    assert traversed_by(ends, origin) == reference_traversal(ends, origin)


def test_rays_along_an_axis_are_straight():
    assert traversed_by([(20, 5, 3)], (15.5, 5.5, 3.5)) == {(x, 5, 3) for x in range(15, 20)}
    assert traversed_by([(15, 5, 0)], (15.5, 5.5, 9.5)) == {(15, 5, z) for z in range(1, 10)}


def test_a_voxel_with_points_is_not_passed():
    marks = np.zeros(SHAPE, dtype=np.uint8)
    marks[17, 5, 3] = HIT
    assert (17, 5, 3) not in traversed_by([(20, 5, 3)], (15.5, 5.5, 3.5), marks)


def test_the_sensor_in_the_voxel_of_its_point_passes_nothing():
    assert traversed_by([(15, 5, 3)], (15.2, 5.7, 3.1)) == set()


def test_ray_exits_are_traversed_unless_hit():
    marks, traversed = np.zeros(SHAPE, dtype=np.uint8), np.empty(10, dtype=np.int32)
    marks.reshape(-1)[5] = HIT
    assert mark_traversed_exits(np.array([4, 5, 6], dtype=np.int32), marks, traversed, 0) == 2
    assert traversed[:2].tolist() == [4, 6]
