"""Moving obstacles: their motion, and that they are no part of the map."""

import math

import numpy as np
import pytest

from reward_planner.core.mapping.moving_points import MovingPoints
from reward_planner.core.navigator import Navigator, NavigatorSettings, SensorFrame
from reward_planner.core.occupancy_map import OCCUPIED, GridFrame
from reward_planner.core.safety.cluster_tracker import ClusterTracker
from reward_planner.core.settings import VoxelSettings
from scene_simulator.mission.pedestrians import Walker
from scene_simulator.room.box_room import BoxRoom, Solids, cast_rays
from shirube_core.geometry import SE2, CameraMount

MOUNT = CameraMount((0.1, 0.0, 0.4), (-math.pi / 2.0, 0.0, -math.pi / 2.0))
WALL = (1.0, 0.9, 0.0, 4.0, 1.0, 1.5)
ROOM = BoxRoom((-2.0, -3.0, 0.0, 7.0, 3.0, 2.6), (WALL,))
F, COLUMNS, ROWS = 80.0, 120, 90
V, U = np.mgrid[0.0:ROWS, 0.0:COLUMNS]
RAYS = np.stack([(U - 59.5) / F, (V - 44.5) / F, np.ones_like(U)], axis=2).reshape(-1, 3)
PERIOD = 0.1


def points_at(solids, pose):
    """What the camera sees from a pose, in the optical frame."""
    cos, sin = math.cos(pose.yaw), math.sin(pose.yaw)
    turn = np.array([[cos, -sin, 0.0], [sin, cos, 0.0], [0.0, 0.0, 1.0]])
    origin = turn @ MOUNT.xyz + (pose.x, pose.y, 0.0)
    return (RAYS * cast_rays(ROOM, solids, origin, RAYS @ (turn @ MOUNT.rotation).T)[:, None]).astype(np.float32)


class Drive:
    """A navigator that looks at somebody while it drives."""

    def __init__(self, speed=0.0):
        self.navigator, self.frames, self._speed = Navigator(MOUNT, NavigatorSettings()), 0, speed

    def look(self, solids):
        stamp, pose = PERIOD * self.frames, SE2(self._speed * PERIOD * self.frames, 0.0, 0.0)
        self.frames += 1
        self.navigator.add_pose(stamp, pose)
        self.navigator.add_frame(stamp, stamp, SensorFrame(points_at(solids, pose), F))
        assert len(self.navigator.process_frames(stamp)) == 1

    def occupied(self, x0, y0, x1, y1):
        frame = GridFrame(x0, y0, 0.05, round((x1 - x0) / 0.05), round((y1 - y0) / 0.05))
        return int((self.navigator.mapper.map.occupancy_in(frame) == OCCUPIED).sum())


def nearest_to(place, obstacles):
    return min(obstacles, key=lambda o: math.hypot(o.position[0] - place.x, o.position[1] - place.y))


ASIDE, AHEAD = SE2(3.0, -1.6, 0.5 * math.pi), SE2(4.8, -0.4, math.pi)


@pytest.mark.parametrize('speed', [0.0, 0.3])
@pytest.mark.parametrize(
    ('start', 'kind'), [(ASIDE, 'person'), (ASIDE, 'legs'), (AHEAD, 'person'), (AHEAD, 'legs'), (AHEAD, 'trolley')]
)
def test_a_walker_is_known_with_his_velocity_and_leaves_nothing_in_the_map(start, kind, speed):
    drive, walker, true = Drive(speed), Walker(kind, start, 1.0), (math.cos(start.yaw), math.sin(start.yaw))
    for _ in range(5):
        drive.look(Solids())
    wall = drive.occupied(2.0, 0.85, 3.5, 1.05)
    for k in range(15):
        drive.look(walker.solids_at(PERIOD * k))
        if k >= 3:  # in the second frame he enters space that was free
            place, obstacles = walker.pose_at(PERIOD * k), drive.navigator.moving_obstacles
            nearest = nearest_to(place, obstacles)
            assert math.dist(nearest.velocity, true) < 0.3
            assert math.dist(nearest.position, (place.x, place.y)) < 0.5
    for _ in range(20):
        drive.look(Solids())
    assert drive.occupied(1.2, -1.5, 5.5, 0.8) == 0
    assert drive.occupied(2.0, 0.85, 3.5, 1.05) >= wall > 10
    assert not drive.navigator.moving_obstacles


@pytest.mark.parametrize(('seconds', 'is_mapped'), [(9.0, False), (14.0, True)])
def test_who_stands_is_expected_to_go_on_then_mapped_and_out_of_the_map_when_he_is_gone(seconds, is_mapped):
    drive = Drive()
    for k in range(round(seconds / PERIOD)):  # comes, and stands from 1 s on
        drive.look(Walker('person', SE2(3.8, 0.0, math.pi), 1.0).solids_at(min(PERIOD * k, 1.0)))
    assert (drive.occupied(2.4, -0.4, 3.2, 0.4) > 0) == is_mapped
    assert [each.is_standing for each in drive.navigator.moving_obstacles] == [True] * (not is_mapped)
    for _ in range(30 if is_mapped else 1):
        drive.look(Solids())
    assert drive.occupied(2.4, -0.4, 3.2, 0.4) == 0
    assert not drive.navigator.moving_obstacles


def test_points_at_rest_are_kept_and_an_older_frame_changes_nothing():
    filter_, T = MovingPoints(VoxelSettings()), np.eye(4)
    T[:3, :3], T[:3, 3] = MOUNT.rotation, MOUNT.xyz
    points = points_at(Solids(), SE2(0.0, 0.0, 0.0))
    for k in range(10):
        assert filter_.static_points(PERIOD * k, points, T) is points
    assert filter_.static_points(0.0, points, T) is points
    assert filter_.obstacles == []


def block(low, high):
    """Cells that fill a rectangle from x = low to high."""
    return np.stack(np.meshgrid(np.arange(low, high, 0.05), np.arange(0.0, 0.3, 0.05)), axis=2).reshape(-1, 2)


@pytest.mark.parametrize(
    ('cells_at', 'moves'),
    [
        (lambda k: block(0.1 * k, 0.1 * k + 0.4), True),
        (lambda k: block(0.0, 0.4 + 0.2 * k), False),  # comes into view
        (lambda k: block(0.1 * k, 1.6), False),  # leaves it
        (lambda k: block(0.4 * (k // 4), 0.4 * (k // 4) + 0.4), False),  # another one
    ],
)
def test_only_what_moves_as_a_whole_has_shifted(cells_at, moves):
    tracker = ClusterTracker()
    for k in range(8):
        motion = tracker.update(PERIOD * k, cells_at(k))
    assert motion.velocity[0, 0] > 0.2
    assert tracker.shifted.all() == tracker.shifted.any() == moves


@pytest.mark.parametrize('sees_rest', [True, False])
def test_the_part_that_left_the_view_moves_on_with_the_rest_until_rays_pass_there(sees_rest):
    tracker = ClusterTracker()
    for k in range(20):
        cells = block(0.1 * k, 0.1 * k + 1.2)
        cells = cells[cells[:, 0] < 2.0]  # the view ends there
        tracker.update(PERIOD * k, cells, lambda xy: (xy[:, 0] < 2.0) | sees_rest)
    hidden = tracker.hidden()
    assert len(hidden.xy) == 0 if sees_rest else hidden.xy[:, 0].max() > 2.5
    assert sees_rest or (hidden.velocity[:, 0] > 0.4).all()


def test_somebody_who_left_the_view_walks_on_or_stands_where_he_was():
    tracker = ClusterTracker()
    for k in range(20):
        cells = block(0.1 * k, 0.1 * k + 0.3) if k < 15 else np.zeros((0, 2))
        tracker.update(PERIOD * k, cells, lambda xy: xy[:, 0] < 1.5)
    hidden = tracker.hidden()
    stands = hidden.velocity[:, 0] == 0.0
    assert stands.any()
    assert (hidden.velocity[~stands, 0] > 0.4).all()
    assert (hidden.sigma[stands] == 0.0).all()
    assert (hidden.sigma[~stands] > 0.0).all()
