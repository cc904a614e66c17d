"""Time of counting points in voxels and of free rays, compared with numpy.bincount and OctoMap.

All methods get the same 272 000 points and run in a new random order in each round, on CPU time of one core. The
settings are the defaults, which `spurious_obstacles` uses too.
"""

from collections.abc import Callable
from functools import partial

import numpy as np
from _figures import ratio, time
from _harness import Option, Run, run_benchmark, side_by_side, use_one_core
from _mapping_methods import PYOCTOMAP, OctoMap
from _voxel_scenes import CAMERA, CAMERA_HEIGHT, NEAR_WALL, ROOM, points_at, stationary_poses, view_at
from numpy.typing import NDArray

from reward_planner.core.mapping.obstacle_mapper import ObstacleMapper
from reward_planner.core.settings import MappingSettings, VoxelSettings
from reward_planner.core.voxels.frame_voxels import FrameVoxelizer
from reward_planner.core.voxels.rolling_voxel_grid import FrameWindow, window_around
from reward_planner.core.voxels.voxel_map import VoxelMap
from scene_simulator.room.box_room import BoxRoom
from shirube_core.geometry import CameraMount

MOUNT = CameraMount((0.0, 0.0, CAMERA_HEIGHT), (-np.pi / 2.0, 0.0, -np.pi / 2.0))
BINCOUNT = 'numpy.bincount, points already in the map frame'


def bincount(points_map: NDArray[np.float32], window: FrameWindow) -> NDArray[np.int64]:
    """Count points in the voxels of a window, shape (side * side * layers,), as one writes it in numpy."""
    shape = np.array([window.side, window.side, window.layers])
    voxels = np.floor((points_map - window.corner) / window.resolution)
    inside = np.isfinite(voxels).all(axis=1) & (voxels >= 0).all(axis=1) & (voxels < shape).all(axis=1)
    cells = np.ravel_multi_index(voxels[inside].astype(np.int64).T, tuple(shape))
    return np.bincount(cells, minlength=int(shape.prod()))


def lean_bincount(points_map: NDArray[np.float32], window: FrameWindow) -> NDArray[np.int64]:
    """Count the same, tuned by hand: column by column, in single precision, without a test for NaN of its own."""
    x, y, z = ((points_map - window.corner.astype(np.float32)) * np.float32(1.0 / window.resolution)).T
    side, layers = window.side, window.layers
    inside = (x >= 0.0) & (x < side) & (y >= 0.0) & (y < side) & (z >= 0.0) & (z < layers)  # NaN is not
    column, row, layer = x[inside].astype(np.int64), y[inside].astype(np.int64), z[inside].astype(np.int64)
    return np.bincount((column * side + row) * layers + layer, minlength=side * side * layers)


def jobs_of(run: Run, room: BoxRoom, settings: VoxelSettings) -> dict[str, Callable[[], object]]:
    """Return what is timed, by name."""
    pose = stationary_poses(1)[0]
    points, view = points_at(room, pose, np.random.default_rng(0)), view_at(pose)
    R, t = view.T_map_sensor[:3, :3].astype(np.float32), view.origin.astype(np.float32)
    points_map = points @ R.T + t
    window, counter = window_around(view, settings), FrameVoxelizer(settings)
    by_count = VoxelMap(VoxelSettings(rule='count', resolution=settings.resolution))
    by_log_odds = VoxelMap(settings)
    mapper = ObstacleMapper(MOUNT, settings, MappingSettings())
    jobs: dict[str, Callable[[], object]] = {
        BINCOUNT: lambda: bincount(points_map, window),
        'the same tuned by hand, in single precision': lambda: lean_bincount(points_map, window),
        'counting, with the transform': lambda: counter.count(points, view),
        'rule `count`: counting and free rays, M, mean in the tiles': lambda: by_count.add(0.0, points, view),
        'counting and free rays': lambda: counter.count_and_trace(points, view),
        'rule `log_odds`: the same into the tiles': lambda: by_log_odds.add(0.0, points, view),
        'the same, local and global map': lambda: mapper.add(0.0, points, pose, CAMERA.fx),
    }
    pyoctomap = run.peer(*PYOCTOMAP)
    if pyoctomap is not None:
        for name, discretize in (('pyoctomap, discretised', True), ('pyoctomap, full rays', False)):
            tree = OctoMap(pyoctomap, settings)  # holds the frame already, as that of a stationary robot
            jobs[name] = partial(tree.insert, points_map, view.origin, discretize=discretize)
    return jobs


def main(run: Run, rounds: int) -> None:
    """Time the jobs."""
    use_one_core()
    for name, room, resolution in (
        ('Room', ROOM, VoxelSettings().resolution),
        ('Room', ROOM, 0.1),
        ('A wall 0.85 m ahead: every point counts', NEAR_WALL, VoxelSettings().resolution),
    ):
        times = side_by_side(jobs_of(run, room, VoxelSettings(resolution=resolution)), rounds)
        table = run.table(f'{name}, voxels of {resolution} m', 'what | ms: median / 95 % | in units of bincount')
        for what, taken in times.items():
            table.add(what, time(taken), '1' if what == BINCOUNT else ratio(taken, times[BINCOUNT]))


if __name__ == '__main__':
    run_benchmark(main, rounds=Option(25, 6, 'how often each method runs'))
