"""The paper's map, rule ``count``: the mean over time (2.2.2, step 3), obstacles and movable area (2.2.3)."""

import numpy as np
import pytest
from scipy.ndimage import binary_dilation, minimum_filter
from test_obstacle_mapper import CAMERA, MOUNT, ROOM, circle, points_at

from reward_planner.core.mapping.obstacle_mapper import ObstacleMapper
from reward_planner.core.occupancy_map import FREE, OCCUPIED
from reward_planner.core.settings import MappingSettings, VoxelSettings
from shirube_core.geometry import SE2

AHEAD = SE2(-2.0, 0.0, 0.0)


def mapper_of(rule: str) -> ObstacleMapper:
    return ObstacleMapper(MOUNT, VoxelSettings(rule=rule, resolution=0.1, range_max=3.0), MappingSettings())


@pytest.mark.parametrize('rule', ['count', 'range_normalised'])
def test_a_drive_maps_obstacles_and_the_movable_area_between_them(rule: str) -> None:
    mapper = mapper_of(rule)
    for k, pose in enumerate(circle(36)):
        mapper.add(0.1 * k, points_at(pose), pose, CAMERA.fx)
    frame, cells = mapper.map.occupancy()
    corner = (frame.origin_x, frame.origin_y)
    solid = ROOM.solid_cells(corner, frame.resolution, frame.shape, (0.1, 1.2))
    assert binary_dilation(solid)[cells == OCCUPIED].all()
    assert not (cells[minimum_filter(solid, 5)] == FREE).any()
    assert (cells == FREE).sum() * frame.resolution**2 > 15.0


def test_what_is_not_in_the_detection_range_stays_unknown() -> None:
    mapper = mapper_of('count')
    local, _ = mapper.add(0.0, points_at(AHEAD), AHEAD, CAMERA.fx)
    places = np.array([(-1.0, 0.0), (-2.6, 0.0), (-1.9, 1.5), (0.75, 0.0)])
    rows, columns = local.frame.cell_of(places).T
    assert [int(cell) for cell in local.occupancy[rows, columns]][:3] == [FREE, -1, -1]
    assert local.occupancy[rows[3], columns[3]] != FREE


@pytest.mark.parametrize(('frames_with_phantom', 'is_obstacle'), [(1, False), (10, True)])
def test_an_obstacle_is_one_of_the_mean_over_the_frames(frames_with_phantom: int, is_obstacle: bool) -> None:
    """A phantom with the highest count of its frame has V = 1 there, a tenth as the mean over ten."""
    mapper = ObstacleMapper(MOUNT, VoxelSettings('count', 0.1, range_max=3.0, value_min=0.2), MappingSettings())
    phantom = np.tile(np.float32([0.0, 0.0, 1.0]), (3000, 1))
    for k in range(10):
        points = points_at(AHEAD)
        if k < frames_with_phantom:
            points = np.concatenate([points, phantom])
        local, _ = mapper.add(0.1 * k, points, AHEAD, CAMERA.fx)
    row, column = local.frame.cell_of(np.array([[AHEAD.x + 0.1 + 1.0, 0.02]]))[0]
    assert (local.occupancy[row, column] == OCCUPIED) == is_obstacle
