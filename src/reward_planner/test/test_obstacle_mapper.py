"""Maps from points, and the projection of voxels: obstacles at the robot's heights, free cells along rays."""

import math
from dataclasses import replace

import numpy as np
import pytest
from scipy.ndimage import minimum_filter

from reward_planner.core.mapping.global_map import GlobalMap, LocalMap
from reward_planner.core.mapping.obstacle_mapper import ObstacleMapper, project_voxels
from reward_planner.core.occupancy_map import FREE, OCCUPIED, UNKNOWN, GridFrame
from reward_planner.core.reward_planner_error import RewardPlannerError
from reward_planner.core.settings import MappingSettings, VoxelSettings
from reward_planner.core.voxels.rolling_voxel_grid import SensorView
from reward_planner.core.voxels.voxel_map import VoxelMap
from scene_simulator.room.box_room import BoxRoom, forward_camera, points_from_depth
from shirube_core.geometry import SE2, CameraMount, PinholeCamera

CAMERA = PinholeCamera(160, 120, 131.0, 131.0, 79.5, 59.5)
MOUNT = CameraMount((0.1, 0.02, 0.5), (-math.pi / 2.0, 0.0, -math.pi / 2.0))
ROOM = BoxRoom(
    (-3.03, -2.52, 0.0, 3.04, 2.53, 2.5), ((0.52, -0.51, 0.0, 1.03, 0.52, 0.8), (-1.98, 1.72, 0.32, -1.03, 2.4, 0.78))
)
SETTINGS = VoxelSettings(resolution=0.1, range_max=3.0)


def points_at(pose, room=ROOM):
    camera = pose @ SE2(MOUNT.xyz[0], MOUNT.xyz[1], 0.0)
    T = forward_camera(camera.x, camera.y, MOUNT.xyz[2], camera.yaw)
    return points_from_depth(room.depth_image(CAMERA, T), CAMERA)


def solid_cells(room, frame, settings=SETTINGS):
    """The cells of a frame that solids of the room fill at the robot's heights."""
    corner, heights = (frame.origin_x, frame.origin_y), (settings.height_min, settings.height_max)
    return room.solid_cells(corner, frame.resolution, frame.shape, heights)


def circle(count=72):
    """Poses on a circle around the box: once round looking at it, once looking out."""
    for k in range(2 * count):
        angle = math.tau * k / count
        yield SE2(0.8 + 1.7 * math.cos(angle), 1.7 * math.sin(angle), angle + (math.pi if k < count else 0.0))


def test_a_drive_maps_the_room():
    mapper = ObstacleMapper(MOUNT, SETTINGS, MappingSettings())
    for k, pose in enumerate(circle()):
        mapper.add(0.1 * k, points_at(pose), pose, CAMERA.fx)
    frame, cells = mapper.map.occupancy()
    solid = solid_cells(ROOM, frame)
    assert solid[cells == OCCUPIED].all()
    inside = minimum_filter(solid, 5)  # rays go to the centres of voxels: they may cut edges of solids
    assert not (cells[inside] == FREE).any()
    faces = [(0.55, 0.0), (1.05, 0.0), (0.75, -0.55), (0.75, 0.55), (3.05, 0.35), (0.75, 2.55), (-1.55, 1.75)]
    assert (cells[tuple(frame.cell_of(faces).T)] == OCCUPIED).all()
    assert (cells == FREE).sum() * frame.resolution**2 > 15.0


def test_the_local_map_is_what_the_global_map_holds_there():
    mapper = ObstacleMapper(MOUNT, SETTINGS, MappingSettings())
    for k, pose in enumerate(circle(20)):
        local, _ = mapper.add(0.1 * k, points_at(pose), pose, CAMERA.fx)
        frame, cells = mapper.map.occupancy()
        seen = np.argwhere(local.observed)
        places = frame.cell_of(local.frame.centre_of(seen))
        assert (cells[tuple(places.T)] == local.occupancy[tuple(seen.T)]).all()


def test_the_same_ground_again_takes_no_memory():
    mapper = ObstacleMapper(MOUNT, SETTINGS, MappingSettings())
    sizes = []
    for lap in range(3):
        for k, pose in enumerate(circle(20)):
            mapper.add(4.0 * lap + 0.1 * k, points_at(pose), pose, CAMERA.fx)
        sizes.append((mapper.map.bytes, mapper.voxels.tiles.bytes, len(mapper.voxels.tiles)))
    assert sizes[0] == sizes[1] == sizes[2]
    mapper.clear()
    assert mapper.map.frame() is None
    assert len(mapper.voxels.tiles) == 0


BEFORE_THE_WALL = SE2(-1.9, 0.0, math.pi)
WALL = (-3.05, 0.0)


def look(mapper, room, pose, stamps):
    for stamp in stamps:
        mapper.add(stamp, points_at(pose, room), pose, CAMERA.fx)


def cell(mapper, x, y):
    frame, cells = mapper.map.occupancy()
    return cells[tuple(frame.cell_of((x, y)))]


@pytest.mark.parametrize('half_life', [1.0, 300.0])
def test_time_alone_never_takes_an_obstacle_from_the_map(half_life):
    settings = replace(SETTINGS, half_life=half_life)
    mapper = ObstacleMapper(MOUNT, settings, MappingSettings())
    look(mapper, ROOM, BEFORE_THE_WALL, 0.1 * np.arange(5))
    away = SE2(BEFORE_THE_WALL.x, BEFORE_THE_WALL.y, 0.0)
    look(mapper, ROOM, away, half_life * np.array([0.5, 1.0, 1.6, 2.5, 7.0, 30.0, 200.0]))
    assert cell(mapper, *WALL) == OCCUPIED
    mapper.voxels.clear()  # nor that its voxels are given up
    look(mapper, ROOM, away, half_life * 200.0 + 0.1 * np.arange(1, 6))
    assert cell(mapper, *WALL) == OCCUPIED


LOW_BOX = (2.2, -0.3, 0.0, 2.6, 0.3, 0.25)


@pytest.mark.parametrize(
    ('x', 'boxes', 'frames', 'found'), [(1.3, (), 30, FREE), *[(2.2, (LOW_BOX,), n, OCCUPIED) for n in (1, 3, 30)]]
)
def test_a_known_box_stays_when_rays_pass_over_it_and_is_found_free_when_it_is_gone(x, boxes, frames, found):
    mapper = ObstacleMapper(MOUNT, SETTINGS, MappingSettings())
    box = GridFrame(x, -0.3, 0.1, 4, 6)
    known = np.full(box.shape, OCCUPIED, dtype=np.int8)
    mapper.map.write(LocalMap(box, known, known == OCCUPIED))
    look(mapper, BoxRoom(ROOM.size, boxes), SE2(0.0, 0.0, 0.0), 0.1 * np.arange(frames))
    np.testing.assert_array_equal(mapper.map.occupancy_in(box), found)


def test_what_stood_close_to_the_robot_and_went_away_is_taken_back():
    mapper, pose = ObstacleMapper(MOUNT, SETTINGS, MappingSettings()), SE2(0.0, 0.0, 0.0)
    person = (0.71, -0.2, 0.0, 0.95, 0.2, 1.7)
    look(mapper, BoxRoom(ROOM.size, (person,)), pose, 0.1 * np.arange(10))
    assert cell(mapper, 0.75, 0.0) == OCCUPIED
    look(mapper, BoxRoom(ROOM.size, ()), pose, 1.0 + 0.1 * np.arange(30))
    assert cell(mapper, 0.75, 0.0) == UNKNOWN  # from so near the camera does not see the floor there


def test_a_pose_that_is_not_finite_is_refused_and_maps_nothing():
    mapper = ObstacleMapper(MOUNT, SETTINGS, MappingSettings())
    with pytest.raises(RewardPlannerError, match='not a rigid transform'):
        mapper.add(0.0, points_at(SE2(0.0, 0.0, 0.0)), SE2(math.nan, 0.0, 0.0), CAMERA.fx)
    assert mapper.map.frame() is None


WIDE_CAMERA = PinholeCamera(320, 240, 262.0, 262.0, 159.5, 119.5)
HALL = (-3.0, -3.5, 0.0, 4.0, 3.5, 2.5)
BOX = (1.53, 0.23, 0.0, 2.02, 0.87, 0.6)
OVERHANG = (1.5, -0.8, 0.85, 2.2, -0.2, 1.0)


def project(boxes, settings=SETTINGS, yaw=0.0, frames=5):
    T = forward_camera(0.0, 0.0, 0.5, yaw)
    room, view = BoxRoom(HALL, boxes), SensorView(T, WIDE_CAMERA.fx)
    points = points_from_depth(room.depth_image(WIDE_CAMERA, T), WIDE_CAMERA)
    voxels = VoxelMap(settings)
    for k in range(frames):
        seen = voxels.add(0.1 * k, points, view)
    local = project_voxels(voxels, view, GlobalMap(settings.resolution, 1_000_000), seen)
    return local, solid_cells(room, local.frame, settings)


def occupancy_at(local, x, y):
    row, column = local.frame.cell_of((x, y))
    return local.occupancy[row, column]


@pytest.mark.parametrize('rule', ['count', 'range_normalised', 'log_odds'])
def test_only_solid_cells_are_occupied(rule):
    local, solid = project((BOX, OVERHANG), replace(SETTINGS, rule=rule))
    assert solid[local.occupancy == OCCUPIED].all()
    assert (local.occupancy == OCCUPIED).sum() >= 5
    np.testing.assert_array_equal(local.observed, local.occupancy != UNKNOWN)


def test_the_face_of_a_box_is_occupied_and_the_floor_before_it_free():
    local, solid = project((BOX,))
    for y in (0.35, 0.45, 0.55, 0.65):
        assert occupancy_at(local, 1.55, y) == OCCUPIED
        assert occupancy_at(local, 1.25, y) == FREE
    # Rows go along y, columns along x.
    centres = local.frame.centre_of(np.argwhere(local.occupancy == OCCUPIED))
    assert centres[:, 0].min() == pytest.approx(1.55)
    assert (centres[:, 1] > 0.2).all()
    # Rays go to the centres of voxels: they may cut the edge of a solid, never its inside.
    inside = minimum_filter(solid, 3)
    assert inside.sum() > 100
    assert not inside[local.occupancy == FREE].any()


@pytest.mark.parametrize(('height_max', 'found'), [(SETTINGS.height_max, OCCUPIED), (0.8, FREE)])
def test_an_overhang_counts_only_if_the_robot_could_hit_it(height_max, found):
    local, _ = project((OVERHANG,), replace(SETTINGS, height_max=height_max))
    assert occupancy_at(local, 1.55, -0.5) == found


def test_cells_behind_a_high_box_stay_unknown():
    local, _ = project(((1.53, -0.5, 0.0, 1.9, 0.5, 1.3),))
    assert occupancy_at(local, 2.5, 0.0) == UNKNOWN
    assert not local.observed[tuple(local.frame.cell_of((2.5, 0.0)))]


@pytest.mark.parametrize(('frames', 'found'), [(1, UNKNOWN), (2, OCCUPIED)])
def test_one_hit_is_no_obstacle_yet(frames, found):
    local, _ = project((BOX,), frames=frames)
    assert occupancy_at(local, 1.55, 0.5) == found
    assert local.observed[tuple(local.frame.cell_of((1.55, 0.5)))] == (found == OCCUPIED)


def test_the_map_turns_with_the_view():
    ahead, _ = project((BOX,))
    aside, _ = project((BOX,), yaw=np.pi)
    assert occupancy_at(ahead, 1.55, 0.5) == OCCUPIED
    assert not aside.observed[tuple(aside.frame.cell_of((1.55, 0.5)))]
    assert occupancy_at(aside, -2.0, 0.0) == FREE


@pytest.mark.parametrize(
    'rule',
    [
        {'log_odds_occupied': 3.3, 'log_odds_max': 3.3},
        {'log_odds_pass': 1.4, 'log_odds_min': -0.7},
        {'log_odds_hit': 0.06, 'log_odds_pass': 5.0, 'log_odds_min': -2.5},
    ],
)
def test_at_the_limits_of_the_rule_there_are_still_obstacles_and_free_cells(rule):
    local, _ = project((BOX,), replace(SETTINGS, **rule), frames=20)
    assert occupancy_at(local, 1.55, 0.5) == OCCUPIED
    assert occupancy_at(local, 1.25, 0.5) == FREE
