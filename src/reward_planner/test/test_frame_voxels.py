"""One frame: hits and traversed voxels against a reference implementation, shifts of the map, point density."""

import math
from collections import Counter
from contextlib import nullcontext

import numpy as np
import pytest
from slow_voxels import cells_as_voxels, centre_of, voxel_of, voxels_on_segment

from reward_planner.core.reward_planner_error import RewardPlannerError
from reward_planner.core.settings import VoxelSettings
from reward_planner.core.voxels import frame_voxels
from reward_planner.core.voxels.frame_voxels import FrameVoxelizer
from reward_planner.core.voxels.rolling_voxel_grid import SensorView
from scene_simulator.room.box_room import BoxRoom, forward_camera, points_from_depth
from shirube_core.geometry import PinholeCamera

SETTINGS = VoxelSettings(resolution=0.125, height_min=0.125, height_max=1.125, range_max=3.0, hit_fraction_min=0.1)
CAMERA = PinholeCamera(80, 60, 66.0, 66.0, 39.5, 29.5)
# Not round numbers: where a ray meets an edge of voxels, both neighbours would be right.
PLACES = [(0.3141, 0.1271, 0.6236, 0.2), (-0.4173, 0.9197, 0.4129, -0.9), (3.1411, -1.2183, 0.9047, 2.3)]
ROOM = BoxRoom((-1.0, -2.0, 0.0, 4.5, 2.0, 2.5), ((1.2, -0.6, 0.0, 1.7, 0.1, 0.7), (2.0, 0.4, 0.8, 2.6, 1.0, 0.9)))


def seen(x=0.3, y=0.1, height=0.6, yaw=0.2):
    T = forward_camera(x, y, height, yaw)
    return points_from_depth(ROOM.depth_image(CAMERA, T), CAMERA), SensorView(T, CAMERA.fx)


def slow_frame(points, view, settings):
    """Hits and traversed voxels by the reference implementation."""
    s, bottom, top = settings.resolution, settings.height_min, settings.height_max
    hits, open_ends, origin = Counter(), Counter(), view.origin
    for point in points.astype(np.float64):
        end = view.T_map_sensor[:3, :3] @ point + origin
        reach = np.linalg.norm(point)
        if settings.range_min <= reach <= settings.range_max and bottom <= end[2] < top:
            hits[voxel_of(end, s, bottom)] += 1
        elif reach >= settings.range_min:
            inside = min(1.0, settings.range_max / reach)
            border = top if end[2] > origin[2] else bottom
            inside = min(inside, (border - origin[2]) / (end[2] - origin[2]))
            place = origin + inside * (1.0 - 1e-12) * (end - origin)
            open_ends[voxel_of(place, s, bottom)] += 1
    axis = view.T_map_sensor[:3, 2]
    depth = {v: axis @ (centre_of(v, s, bottom) - origin) for v in hits}
    firm = {v for v, n in hits.items() if n >= settings.hit_fraction_min * (view.focal_length * s / depth[v]) ** 2}
    wide = {v for v, n in open_ends.items() if n >= 2}
    traversed = set(wide)
    for end in firm | wide:
        traversed |= voxels_on_segment(origin, centre_of(end, s, bottom), s, bottom)
    return hits, traversed - set(hits)


@pytest.mark.parametrize('place', PLACES)
def test_hits_and_free_voxels_are_those_of_a_plain_implementation(place):
    points, view = seen(*place)
    frame = FrameVoxelizer(SETTINGS).count_and_trace(points, view)
    hits, traversed = slow_frame(points, view, SETTINGS)
    assert dict(zip(cells_as_voxels(frame.cells, frame.window), frame.counts.tolist())) == dict(hits)
    assert set(cells_as_voxels(frame.traversed, frame.window)) == traversed
    assert len(traversed) > 300
    for voxel, expected in zip(cells_as_voxels(frame.cells, frame.window), frame.expected):
        centre = centre_of(voxel, SETTINGS.resolution, SETTINGS.height_min)
        depth = view.T_map_sensor[:3, 2] @ (centre - view.origin)
        assert expected == pytest.approx((CAMERA.fx * SETTINGS.resolution / depth) ** 2)


@pytest.mark.parametrize('shift', [(1, 0), (-3, 5), (16, -32), (1007, 2047)])
def test_voxels_shift_with_the_sensor(shift):
    points, view = seen()
    T = view.T_map_sensor.copy()
    T[:2, 3] += np.array(shift) * SETTINGS.resolution
    counter = FrameVoxelizer(SETTINGS)
    here, there = (counter.count_and_trace(points, v) for v in (view, SensorView(T, CAMERA.fx)))
    for cells_here, cells_there in ((here.cells, there.cells), (here.traversed, there.traversed)):
        moved = {(x + shift[0], y + shift[1], z) for x, y, z in cells_as_voxels(cells_here, here.window)}
        assert moved == set(cells_as_voxels(cells_there, there.window))


def test_a_wall_across_the_axis_gives_the_expected_points():
    camera = PinholeCamera(640, 480, 525.0, 525.0, 319.5, 239.5)
    for distance in (1.03, 1.9, 2.8):
        room = BoxRoom((-1.0, -3.0, -1.0, distance, 3.0, 2.5))
        T = forward_camera(0.0, 0.0, 0.6, 0.0)
        points = points_from_depth(room.depth_image(camera, T), camera)
        frame = FrameVoxelizer(SETTINGS).count(points, SensorView(T, camera.fx))
        voxels = cells_as_voxels(frame.cells, frame.window)
        ahead = [i for i, (x, y, z) in enumerate(voxels) if abs(y) < 3 and 2 < z < 5 and x > 5]
        assert len(ahead) >= 10
        assert frame.counts[ahead] == pytest.approx(frame.expected[ahead], rel=0.15)


def test_bad_points_change_nothing():
    points, view = seen()
    worse = np.concatenate([points, [[math.nan, 0.0, 1.0], [0.0, math.inf, 1.0], [0.0, 0.0, -math.inf]]])
    good, bad = (FrameVoxelizer(SETTINGS).count_and_trace(p, view) for p in (points, worse))
    assert set(good.cells.tolist()) == set(bad.cells.tolist())
    assert set(good.traversed.tolist()) == set(bad.traversed.tolist())
    assert (good.point_counts.not_finite, bad.point_counts.not_finite) == (0, 3)


@pytest.mark.parametrize('height', [0.05, 1.2])
def test_level_rays_outside_of_the_heights_free_nothing_and_leave_nothing_behind(height):
    T = np.eye(4)  # exactly level, as no camera of a rendered room is
    T[:3, :3] = [[0.0, 0.0, 1.0], [-1.0, 0.0, 0.0], [0.0, -1.0, 0.0]]
    T[:3, 3] = 0.3, 0.1, height
    level = np.array([[0.05 * k, 0.0, 2.0] for k in range(-9, 10)] + [[0.0, 0.0, 9.0]], dtype=np.float32)
    slanted = level[:-1] + np.array([0.0, np.copysign(0.4, height - 0.5), 0.0], dtype=np.float32)
    counter, view = FrameVoxelizer(SETTINGS), SensorView(T, CAMERA.fx)
    alone = counter.count_and_trace(slanted, view)
    both = counter.count_and_trace(np.concatenate([slanted, level]), view)
    assert len(alone.traversed) > 0
    assert set(alone.traversed.tolist()) == set(both.traversed.tolist())
    assert both.point_counts.too_low_or_high == 19
    assert len(counter.count_and_trace(level, view).traversed) == 0


@pytest.mark.parametrize('fails', [False, True])
def test_a_frame_leaves_nothing_behind_in_the_work_space_even_if_it_fails(monkeypatch, fails):
    counter = FrameVoxelizer(SETTINGS)
    first = counter.count_and_trace(*seen())

    def fail(cells, *_):
        raise ZeroDivisionError

    with monkeypatch.context() as patch, pytest.raises(ZeroDivisionError) if fails else nullcontext():
        if fails:
            patch.setattr(frame_voxels, 'mark_traversed_exits', fail)
        counter.count_and_trace(*seen() if fails else seen(1.0, -0.8, 0.4, 1.5))
    again = counter.count_and_trace(*seen())
    for name in ('cells', 'counts', 'traversed'):
        assert (getattr(first, name) == getattr(again, name)).all()


def test_single_points_far_behind_free_nothing():
    points, view = seen()
    wall = points[:, 2].max()
    stray = np.array([[0.01 * k, 0.3, wall + 0.4 * k] for k in range(1, 4)])
    clean = FrameVoxelizer(SETTINGS).count_and_trace(points, view)
    strayed = FrameVoxelizer(SETTINGS).count_and_trace(np.concatenate([points, stray]), view)
    assert len(strayed.traversed) <= len(clean.traversed)


@pytest.mark.parametrize('points', [np.zeros((3, 2)), np.zeros(3), np.zeros((2, 3, 3))])
def test_points_of_another_shape_are_refused(points):
    with pytest.raises(RewardPlannerError, match='one row x, y, z per point'):
        FrameVoxelizer(SETTINGS).count(points, seen()[1])
