"""Compiles the numba kernels before the first frame."""

import numpy as np

from reward_planner.core.depth.trinocular_depth import fuse_disparities, points_from_depth_image
from reward_planner.core.mapping.global_map import LocalMap
from reward_planner.core.navigator import Navigator, NavigatorSettings, SensorFrame
from reward_planner.core.occupancy_map import FREE, OCCUPIED, GridFrame
from reward_planner.core.voxels.rolling_voxel_grid import equivalent_focal_length
from shirube_core.geometry import SE2, CameraMount, PinholeCamera

_CAMERA = PinholeCamera(16, 12, 12.0, 12.0, 7.5, 5.5)
_GOAL = SE2(-1.0, 0.3, 0.0)


def compile_kernels(mount: CameraMount, settings: NavigatorSettings) -> None:
    """Compile the kernels: map a frame, plan and replan a route with these settings, and fuse two disparity images."""
    navigator = Navigator(mount, settings)
    middle = 0.5 * (settings.voxels.range_min + settings.voxels.range_max)
    depth = np.full((_CAMERA.height, _CAMERA.width), middle, dtype=np.float32)
    points = points_from_depth_image(depth, _CAMERA)
    for focal_length in (0.0, equivalent_focal_length(points)):
        navigator.add_frame(1.0, 1.0, SensorFrame(points, focal_length))
    navigator.add_pose(1.0, SE2(0.0, 0.0, 0.0))
    navigator.controller.set_goal(_GOAL)
    navigator.process_frames(1.0)
    cell = _cell_on_route(settings.voxels.resolution)
    _write(navigator, 1.0, cell, FREE)
    navigator.controller.step(1.0)
    later = 1.1 + settings.driving.replan_period
    _write(navigator, later, cell, OCCUPIED)
    navigator.add_pose(later, SE2(-settings.voxels.resolution, 0.0, 0.0))
    navigator.controller.step(later)
    fuse_disparities(depth, depth, (1.0, 1.0), 1.0, True)


def compile_default_kernels() -> None:
    """Compile the kernels for the default settings."""
    compile_kernels(CameraMount(), NavigatorSettings())


def _cell_on_route(resolution: float) -> GridFrame:
    """Return a cell halfway to the goal."""
    column, row = (round(0.5 * number / resolution) for number in (_GOAL.x, _GOAL.y))
    return GridFrame(column * resolution, row * resolution, resolution, 1, 1)


def _write(navigator: Navigator, stamp: float, frame: GridFrame, value: int) -> None:
    cells = np.full(frame.shape, value, dtype=np.int8)
    navigator.mapper.map.write(LocalMap(frame, cells, cells == value))
    navigator.controller.update_map(stamp, frame)
