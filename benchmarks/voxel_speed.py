"""Time of counting and of free rays, compared with numpy.bincount and OctoMap: `./shirube bench voxel_speed`.

All methods get the same 272 000 points and run in a new random order in each round, on CPU time of this process, which
runs on one core. Ratios are taken within rounds. The settings are the defaults, which `spurious_obstacles` uses too.
"""

from __future__ import annotations

import argparse
import os
import time
from collections.abc import Callable

os.environ['OPENBLAS_NUM_THREADS'] = '1'

import numpy as np
from _peer_octomap import INSTALL, IS_INSTALLED, insert_into_octomap
from _voxel_scenes import CAMERA, CAMERA_HEIGHT, NEAR_WALL, POINTS, ROOM, points_at, stationary_poses, view_at
from numpy.typing import NDArray
from tqdm import tqdm

from reward_planner.core.mapping.mapping_settings import MappingSettings
from reward_planner.core.mapping.obstacle_mapper import ObstacleMapper
from reward_planner.core.voxels.frame_voxels import FrameVoxelizer
from reward_planner.core.voxels.frame_window import FrameWindow, window_around
from reward_planner.core.voxels.voxel_map import VoxelMap
from reward_planner.core.voxels.voxel_settings import VoxelSettings
from scene_simulator.room.box_room import BoxRoom
from shirube_core.geometry import CameraMount

Job = Callable[[], object]
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


def jobs_of(room: BoxRoom, settings: VoxelSettings) -> dict[str, Job]:
    """Return what is timed, by name."""
    pose = stationary_poses(1)[0]
    points, view = points_at(room, pose, np.random.default_rng(0)), view_at(pose)
    R, t = view.T_map_sensor[:3, :3].astype(np.float32), view.origin.astype(np.float32)
    points_map = points @ R.T + t
    window, counter = window_around(view, settings), FrameVoxelizer(settings)
    by_count = VoxelMap(VoxelSettings(rule='count', resolution=settings.resolution))
    by_log_odds = VoxelMap(settings)
    mapper = ObstacleMapper(MOUNT, settings, MappingSettings())
    check_counts(bincount(points_map, window), counter, points, settings)
    jobs: dict[str, Job] = {
        BINCOUNT: lambda: bincount(points_map, window),
        'the same tuned by hand, in single precision': lambda: lean_bincount(points_map, window),
        'counting, with the transform': lambda: counter.count(points, view),
        'rule `count`: counting, M, mean in the tiles': lambda: by_count.add(0.0, points, view),
        'counting and free rays': lambda: counter.count_and_trace(points, view),
        'rule `log_odds`: the same into the tiles': lambda: by_log_odds.add(0.0, points, view),
        'the same, local and global map': lambda: mapper.add(0.0, points, pose, CAMERA.fx),
    }
    if IS_INSTALLED:
        for name, discretize in (('pyoctomap, discretised', True), ('pyoctomap, full rays', False)):
            jobs[name] = lambda d=discretize: insert_into_octomap(points_map, view.origin, settings, d)  # type: ignore[misc]
    return jobs


def check_counts(
    counts: NDArray[np.int64], counter: FrameVoxelizer, points: NDArray[np.float32], settings: VoxelSettings
) -> None:
    """Say how many points both counts have, and how far they differ."""
    frame = counter.count(points, view_at(stationary_poses(1)[0]))
    ours = np.zeros_like(counts)
    ours[frame.cells] = frame.counts
    print(
        f'\nOf {len(points)} points bincount counts {counts.sum()} in {np.count_nonzero(counts)} voxels, we, up to '
        f'{settings.range_max} m, {ours.sum()} in {len(frame.cells)}.\n'
    )


def time_of(job: Job) -> float:
    """Run a job once and return its CPU time [ms]."""
    start = time.process_time()
    job()
    return 1e3 * (time.process_time() - start)


def print_table(jobs: dict[str, Job], rounds: int) -> None:
    """Run all jobs in rounds and print their times."""
    names, rng = list(jobs), np.random.default_rng(0)
    times = np.empty((rounds, len(names)))
    peers = [i for i, name in enumerate(names) if 'pyoctomap' in name]
    others = [i for i in range(len(names)) if i not in peers]
    for k in tqdm(range(-1, rounds), leave=False):  # the first round compiles
        jobs[BINCOUNT]()  # OctoMap came last and left nothing of the points in the processor's caches
        for i in (*rng.permutation(others), *peers):
            times[max(k, 0), i] = time_of(jobs[names[i]])
    ratios, tuned = times / times[:, :1], times[:, 1:2] / times
    print(
        '| what | ms: median / 95 % | of bincount: median / 95 % | bincount over it | tuned bincount over it |\n'
        '|---|---|---|---|---|'
    )
    for i, name in enumerate(names):
        (slow, late), (share, late_share) = (np.percentile(a[:, i], [50.0, 95.0]) for a in (times, ratios))
        print(
            f'| {name} | {slow:.2f} / {late:.2f} | {share:.3f} / {late_share:.3f} | {1.0 / share:.1f} | '
            f'{np.median(tuned[:, i]):.1f} |'
        )


def main() -> int:
    """Print the tables."""
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument('--rounds', type=int, default=25, help='how often each method runs')
    rounds = parser.parse_args().rounds
    os.sched_setaffinity(0, {max(os.sched_getaffinity(0))})
    if not IS_INSTALLED:
        print(INSTALL)
    print(f'## Speed of voxels\n\n`./shirube bench voxel_speed`: {POINTS} points a frame; times of one core.')
    for name, room, resolution in (
        ('Room', ROOM, VoxelSettings().resolution),
        ('Room', ROOM, 0.1),
        ('A wall 0.85 m ahead: every point counts', NEAR_WALL, VoxelSettings().resolution),
    ):
        print(f'\n### {name}, voxels of {resolution} m')
        print_table(jobs_of(room, VoxelSettings(resolution=resolution)), rounds)
    return 0


if __name__ == '__main__':
    raise SystemExit(main())
