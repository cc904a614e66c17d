"""Points in voxels: none is lost, none is counted twice."""

from __future__ import annotations

import numpy as np

from reward_planner.core.voxels.frame_kernels import count_points

RANGES = (0.3, 3.0)
SHAPE = (64, 64, 12)


def window_transform():
    angle = 0.7
    T = np.array(
        [
            [np.cos(angle), 0.0, np.sin(angle), 3.2],
            [-np.sin(angle), 0.0, np.cos(angle), 3.1],
            [0.0, -1.0, 0.0, 0.4],
        ]
    )
    return T / 0.1


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


def test_counts_are_those_of_a_histogram():
    points, T = cloud(), window_transform()
    counts, cells, _ = counted(points, T)
    points = points[np.isfinite(points).all(axis=1)].astype(np.float64)
    distances = np.linalg.norm(points, axis=1)
    near_enough = points[(distances >= RANGES[0]) & (distances <= RANGES[1])]
    voxels = near_enough @ T[:, :3].T + T[:, 3]
    histogram, _ = np.histogramdd(voxels, [np.arange(n + 1) for n in SHAPE])
    assert (counts == histogram).all()
    assert sorted(cells) == np.flatnonzero(histogram).tolist()


def test_the_order_of_the_points_does_not_matter():
    points, T = cloud(), window_transform()
    mixed = np.ascontiguousarray(points[np.random.default_rng(1).permutation(len(points))])
    assert (counted(points, T)[0] == counted(mixed, T)[0]).all()


def test_no_points_give_no_voxels():
    counts, cells, point_counts = counted(np.empty((0, 3), dtype=np.float32), window_transform())
    assert counts.sum() == len(cells) == sum(point_counts) == 0
