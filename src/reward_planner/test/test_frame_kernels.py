"""Points in voxels are counted once; rays are those cut at every face."""

import numpy as np
import pytest
from slow_voxels import voxels_on_segment

from reward_planner.core.voxels.frame_kernels import HIT, TRAVERSED, count_points, mark_traversed, mark_traversed_exits

RANGES = (0.3, 3.0)
SHAPE = (64, 64, 12)


def window_transform():
    cos, sin = np.cos(0.7), np.sin(0.7)
    return np.array([[cos, 0.0, sin, 3.2], [-sin, 0.0, cos, 3.1], [0.0, -1.0, 0.0, 0.4]]) / 0.1


def cloud(count=5000):
    points = np.random.default_rng(0).normal(0.0, 1.5, (count, 3)).astype(np.float32)
    points[::50, 1] = np.nan
    points[7::50, 0] = np.inf
    points[9::50, 2] = -np.inf
    return points


def counted(points, T):
    counts, cells = np.zeros(SHAPE, dtype=np.int32), np.empty(np.prod(SHAPE), dtype=np.int32)
    filled, point_counts = count_points(points, T, RANGES, counts, cells)
    return counts, cells[:filled], point_counts


def test_every_point_is_counted_once_or_reported_as_dropped():
    points = cloud()
    counts, _, point_counts = counted(points, window_transform())
    assert counts.sum() == point_counts.counted
    assert sum(point_counts) == len(points)
    assert point_counts.not_finite == (~np.isfinite(points)).any(axis=1).sum()
    distances = np.linalg.norm(points[np.isfinite(points).all(axis=1)].astype(np.float64), axis=1)
    assert point_counts.too_near == (distances < RANGES[0]).sum()
    assert point_counts.too_far == (distances > RANGES[1]).sum()


@pytest.mark.parametrize('count', [0, 5000])
def test_counts_are_those_of_a_histogram(count):
    points, T = cloud(count), window_transform()
    counts, cells, _ = counted(points, T)
    points = points[np.isfinite(points).all(axis=1)].astype(np.float64)
    distances = np.linalg.norm(points, axis=1)
    near_enough = points[(distances >= RANGES[0]) & (distances <= RANGES[1])]
    voxels = near_enough @ T[:, :3].T + T[:, 3]
    histogram, _ = np.histogramdd(voxels, [np.arange(n + 1) for n in SHAPE])
    assert (counts == histogram).all()
    assert sorted(cells) == np.flatnonzero(histogram).tolist()


WINDOW = (32, 32, 10)


def traversed_by(ends, origin, marks=None):
    """Traversed voxels by the code under test."""
    marks = np.zeros(WINDOW, dtype=np.uint8) if marks is None else marks
    traversed = np.empty(marks.size, dtype=np.int32)
    flat = np.array([np.ravel_multi_index(end, WINDOW) for end in ends], dtype=np.int32)
    count = mark_traversed(flat, np.array(origin), marks, traversed, 0)
    assert len(set(traversed[:count].tolist())) == count
    assert (np.flatnonzero(marks == TRAVERSED) == np.sort(traversed[:count])).all()
    return {tuple(int(i) for i in np.unravel_index(cell, WINDOW)) for cell in traversed[:count]}


def reference_traversal(ends, origin):
    """Traversed voxels by the reference implementation, within the window and without the ends."""
    way = [voxels_on_segment(origin, np.array(end) + 0.5, 1.0, 0.0) - {end} for end in ends]
    return {v for v in set().union(*way) if 0 <= v[2] < WINDOW[2]}


@pytest.mark.parametrize('height', [4.3, -3.7, 14.2])
def test_rays_pass_the_voxels_that_they_cut(height):
    rng = np.random.default_rng(3)
    for _ in range(150):
        origin = (*rng.uniform(10.0, 22.0, 2), height + rng.uniform(-0.2, 0.2))
        end = tuple(int(rng.integers(0, n)) for n in WINDOW)
        assert traversed_by([end], origin) == reference_traversal([end], origin)


def test_many_rays_pass_what_each_of_them_passes():
    rng = np.random.default_rng(4)
    ends = [tuple(int(rng.integers(0, n)) for n in WINDOW) for _ in range(100)]
    origin = (15.3141, 16.8271, 4.2236)  # no ray meets an edge, where both neighbours would be right
    assert traversed_by(ends, origin) == reference_traversal(ends, origin)


def test_rays_along_an_axis_are_straight_and_pass_no_voxel_with_points():
    assert traversed_by([(20, 5, 3)], (15.5, 5.5, 3.5)) == {(x, 5, 3) for x in range(15, 20)}
    assert traversed_by([(15, 5, 0)], (15.5, 5.5, 9.5)) == {(15, 5, z) for z in range(1, 10)}
    assert traversed_by([(15, 5, 3)], (15.2, 5.7, 3.1)) == set()
    marks = np.zeros(WINDOW, dtype=np.uint8)
    marks[17, 5, 3] = HIT
    assert (17, 5, 3) not in traversed_by([(20, 5, 3)], (15.5, 5.5, 3.5), marks)


def test_ray_exits_are_traversed_unless_hit():
    marks, traversed = np.zeros(WINDOW, dtype=np.uint8), np.empty(10, dtype=np.int32)
    marks.reshape(-1)[5] = HIT
    assert mark_traversed_exits(np.array([4, 5, 6], dtype=np.int32), marks, traversed, 0) == 2
    assert traversed[:2].tolist() == [4, 6]
