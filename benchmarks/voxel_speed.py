"""Time of counting and of free rays, beside numpy.bincount and OctoMap: `./shirube bench voxel_speed`.

All methods get the same 272 000 points and run one after the other in each round, on CPU time of this process, which is
let onto one core only. Ratios are taken within rounds. The settings are the defaults, which `ghosts` uses too.
"""

from __future__ import annotations

import argparse
import os
import time
from collections.abc import Callable

os.environ['OPENBLAS_NUM_THREADS'] = '1'

import numpy as np
from _peer_octomap import INSTALL, IS_INSTALLED, insert_into_octomap
from _voxel_scenes import CAMERA, CAMERA_HEIGHT, NEAR_WALL, POINTS, ROOM, points_at, standing, view_at
from numpy.typing import NDArray
from tqdm import tqdm

from reward_planner.core.mapping.mapping_settings import MappingSettings
from reward_planner.core.mapping.obstacle_mapper import ObstacleMapper
from reward_planner.core.voxels.frame_voxels import FrameCounter
from reward_planner.core.voxels.frame_window import FrameWindow, window_around
from reward_planner.core.voxels.voxel_map import VoxelMap
from reward_planner.core.voxels.voxel_settings import VoxelSettings
from scene_simulator.box_room import BoxRoom
from shirube_geometry import CameraMount

Job = Callable[[], object]
MOUNT = CameraMount((0.0, 0.0, CAMERA_HEIGHT), (-np.pi / 2.0, 0.0, -np.pi / 2.0))
BINCOUNT = 'numpy.bincount, points already in the map frame'


def bincount(points_map: NDArray[np.float32], window: FrameWindow) -> NDArray[np.int64]:
    """Count points in the voxels of a window, shape (side * side * layers,)."""
    x, y, z = ((points_map - window.corner.astype(np.float32)) * np.float32(1.0 / window.resolution)).T
    side, layers = window.side, window.layers
    inside = (x >= 0.0) & (x < side) & (y >= 0.0) & (y < side) & (z >= 0.0) & (z < layers)  # NaN is not
    column, row, layer = x[inside].astype(np.int64), y[inside].astype(np.int64), z[inside].astype(np.int64)
    return np.bincount((column * side + row) * layers + layer, minlength=side * side * layers)


def jobs_of(room: BoxRoom, settings: VoxelSettings) -> dict[str, Job]:
    """Return what is timed, by name."""
    pose = standing(1)[0]
    points, view = points_at(room, pose, np.random.default_rng(0)), view_at(pose)
    R, t = view.T_map_sensor[:3, :3].astype(np.float32), view.origin.astype(np.float32)
    points_map = points @ R.T + t
    window, counter = window_around(view, settings), FrameCounter(settings)
    by_count = VoxelMap(VoxelSettings(rule='count', resolution=settings.resolution))
    by_log_odds = VoxelMap(settings)
    mapper = ObstacleMapper(MOUNT, settings, MappingSettings())
    check_counts(bincount(points_map, window), counter, points, settings)
    jobs: dict[str, Job] = {
        BINCOUNT: lambda: bincount(points_map, window),
        'the same, with their transform': lambda: bincount(points @ R.T + t, window),
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
    counts: NDArray[np.int64], counter: FrameCounter, points: NDArray[np.float32], settings: VoxelSettings
) -> None:
    """Say how many points both counts have, and how far they differ."""
    frame = counter.count(points, view_at(standing(1)[0]))
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
    for job in jobs.values():
        job()
    times = np.array([[time_of(job) for job in jobs.values()] for _ in tqdm(range(rounds), leave=False)])
    ratios = times / times[:, list(jobs).index(BINCOUNT)][:, None]
    print('| what | ms: median / 95 % | of bincount: median / 95 % | bincount over it |\n|---|---|---|---|')
    for i, name in enumerate(jobs):
        (slow, late), (share, late_share) = (np.percentile(a[:, i], [50.0, 95.0]) for a in (times, ratios))
        print(f'| {name} | {slow:.2f} / {late:.2f} | {share:.3f} / {late_share:.3f} | {1.0 / share:.1f} |')


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
