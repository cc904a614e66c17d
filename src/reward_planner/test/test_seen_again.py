"""Obstacles that went away: rays of any density clear them, and what is left of them out of view."""

import math

import numpy as np
import pytest

from reward_planner.core.depth.trinocular_depth import points_from_depth_image
from reward_planner.core.mapping.obstacle_mapper import ObstacleMapper
from reward_planner.core.occupancy_map import OCCUPIED, GridFrame
from reward_planner.core.settings import MappingSettings, VoxelSettings
from reward_planner.core.voxels.seen_again import ray_image
from scene_simulator.room.box_room import BoxRoom
from shirube_core.geometry import SE2, CameraMount, PinholeCamera

MOUNT = CameraMount((0.0, 0.0, 0.4), (-math.pi / 2.0, 0.0, -math.pi / 2.0))
HALL = (-1.0, -1.5, 0.0, 20.0, 1.5, 2.6)
SENSOR_RANGE = 6.0
MEMORY = 0.3


def camera(columns: int, rows: int, view: float) -> PinholeCamera:
    """A camera with a vertical field of view in degrees."""
    f = 0.5 * rows / math.tan(0.5 * math.radians(view))
    return PinholeCamera(columns, rows, f, f, 0.5 * (columns - 1), 0.5 * (rows - 1))


class Robot:
    """A mapper, and a camera that looks along x; what is farther than its range returns nothing."""

    def __init__(self, seen_by, no_return=math.inf):
        self.mapper = ObstacleMapper(MOUNT, VoxelSettings(obstacle_memory=MEMORY), MappingSettings())
        self._camera, self._no_return, self.time = seen_by, no_return, 0.0

    def look(self, boxes, x, seconds):
        """Look at boxes from a place for some seconds, ten times a second."""
        pose = SE2(x, 0.0, 0.0)
        T = np.eye(4)
        T[:3, :3], T[:3, 3] = MOUNT.rotation, (x, 0.0, MOUNT.xyz[2])
        depth = BoxRoom(HALL, tuple(boxes)).depth_image(self._camera, T)
        depth[depth > SENSOR_RANGE] = self._no_return
        points = points_from_depth_image(depth, self._camera)
        for _ in range(round(10.0 * seconds)):
            self.mapper.add(self.time, points, pose, self._camera.fx)
            self.time += 0.1

    def occupied(self, low, high):
        """The number of occupied cells between two corners."""
        columns, rows = (round((b - a) / 0.05) for a, b in zip(low, high, strict=True))
        cells = self.mapper.map.occupancy_in(GridFrame(*low, 0.05, columns, rows))
        return int((cells == OCCUPIED).sum())


AROUND = (2.5, -0.8), (3.5, 0.8)
PERSON = (2.9, -0.2, 0.0, 3.15, 0.2, 1.75)


@pytest.mark.parametrize('pixels', [(80, 60), (120, 90), (240, 180)])
@pytest.mark.parametrize('view', [30, 60, 90])
@pytest.mark.parametrize('is_first_sight', [True, False])
def test_who_left_a_hall_leaves_nothing_in_the_map_at_any_density_and_view(pixels, view, is_first_sight):
    robot = Robot(camera(*pixels, view))
    if not is_first_sight:
        robot.look((), 0.0, 1.0)
    for x in (0.0, 0.7, 1.4, 2.0):
        robot.look((PERSON,), x, 0.7)
    assert robot.occupied(*AROUND) > 0
    robot.look((), 2.0, 2.0 + (10.0 * MEMORY if is_first_sight else MEMORY))
    assert robot.occupied(*AROUND) == 0


@pytest.mark.parametrize(('no_return', 'is_cleared'), [(math.inf, True), (math.nan, False)])
def test_rays_that_return_nothing_clear_and_invalid_ones_do_not(no_return, is_cleared):
    robot, person = Robot(camera(160, 120, 20), no_return), (4.5, -0.2, 0.0, 4.8, 0.2, 1.75)
    robot.look((person,), 0.5, 1.0)
    before = robot.occupied((4.4, -0.15), (4.9, 0.15))
    assert before > 0
    robot.look((), 0.5, 2.0)
    after = robot.occupied((4.4, -0.15), (4.9, 0.15))
    assert after == (0 if is_cleared else before)


LOW_BOX = (2.6, -0.4, 0.0, 3.0, 0.4, 0.25)
TABLE = (2.4, -0.6, 0.75, 3.6, 0.6, 0.8)
LEGS = (2.4, -0.15, 0.0, 2.6, 0.15, 0.5)
STOOL = (2.75, -0.2, 0.0, 3.15, 0.2, 0.25)
ON_STOOL = (2.75, -0.2, 0.25, 3.15, 0.2, 1.3)


@pytest.mark.parametrize(
    ('at_first', 'afterwards', 'x', 'seconds'),
    [
        ((LOW_BOX,), (LOW_BOX,), 2.1, 20.0 * MEMORY),
        ((TABLE, LEGS), (TABLE,), 1.4, 20.0 * MEMORY),
        ((STOOL, ON_STOOL), (STOOL,), 2.4, 8.0 * MEMORY),
    ],
)
def test_what_rests_out_of_view_stays(at_first, afterwards, x, seconds):
    robot = Robot(camera(120, 90, 30))
    for place in (0.0, 0.5, 1.0, x):
        robot.look(at_first, place, 0.6)
    x0, y0, _, _, y1, _ = afterwards[0]
    front = (x0, y0), (x0 + 0.05, y1)
    before = robot.occupied(*front)
    robot.look(afterwards, x, seconds)
    assert robot.occupied(*front) == before > 0


def test_a_ray_image_holds_the_nearest_ray_of_each_direction_and_0_where_none_is():
    points = np.array([(0.0, 0.0, 2.0), (0.0, 0.0, 1.0), (0.5, 0.0, 1.0), (0.0, 0.0, np.nan), (0.0, 0.0, -1.0)])
    image = ray_image(points.astype(np.float32), 20.0)
    assert image.width == pytest.approx(0.1)
    assert np.sort(image.depth[image.depth > 0.0]).tolist() == [1.0, 1.0]
    middle = len(image.depth) // 2
    assert image.depth[middle, middle] == 1.0
    assert image.depth[middle, middle + 5] == 1.0
