"""Spurious obstacles that a map keeps, and real ones that it loses: `./shirube bench spurious_obstacles`.

40 frames in which 3 % of the pixels show phantoms, then 40 clean ones. A false cell is occupied though nothing solid
is there, and never was so in a run of the same method on the same frames without phantoms (noise of the depth thickens
walls in any case). It had free rays if a clean frame's rays passed one of its false voxels. A true cell is solid and
occupied in the run without phantoms. Settings are the defaults, which `voxel_speed` uses too.
"""

from __future__ import annotations

import argparse
from collections.abc import Callable, Iterator
from typing import NamedTuple, NoReturn

import numpy as np
from _mapping_methods import (
    FIRST_TILE,
    TILES,
    Cloud,
    Dense,
    FrameUnion,
    Method,
    OctoMapMethod,
    Voxels,
    dense_shape,
)
from _peer_octomap import INSTALL, IS_INSTALLED
from _voxel_scenes import ROOM, moving_poses, points_at, stationary_poses, view_at
from numpy.typing import NDArray
from tqdm import tqdm

from reward_planner.core.voxels.frame_voxels import FrameVoxelizer
from reward_planner.core.voxels.frame_window import TILE_SIZE, SensorView
from reward_planner.core.voxels.voxel_settings import VoxelSettings
from shirube_core.geometry import SE2

FRAMES = 40
FRACTION = 0.03
PERIOD = 0.1
SETTINGS = VoxelSettings()
METHODS: dict[str, Callable[[], Method]] = {
    'the paper: `count`, frames joined by OR': lambda: FrameUnion(VoxelSettings(rule='count')),
    '`count`, mean over time': lambda: Voxels(VoxelSettings(rule='count')),
    '`range_normalised`, mean over time': lambda: Voxels(VoxelSettings(rule='range_normalised')),
    '`log_odds`': lambda: Voxels(SETTINGS),
    '`log_odds`, as a point cloud': lambda: Cloud(SETTINGS),
}
if IS_INSTALLED:
    METHODS['pyoctomap'] = lambda: OctoMapMethod(SETTINGS)
PHANTOMS = {
    'single points, new ones in each frame': (1, False),
    'patches of 8 x 8, new ones in each frame': (8, False),
    'patches of 24 x 24, new ones in each frame': (24, False),
    'patches of 24 x 24, the same in all frames': (24, True),
}


class Scores(NamedTuple):
    """Cells of one run."""

    false_before: int
    false_after: int
    false_with_rays: int
    true: int
    lost: int


class CleanRun(NamedTuple):
    """Voxels that a method held occupied without phantoms: ever, and in the end."""

    ever: Dense
    last: Dense


def frames_of(
    poses: list[SE2], patch: int | None, *, same: bool, seed: int
) -> Iterator[tuple[NDArray[np.float32], SensorView]]:
    """Yield the frames of a run, with phantoms in the first FRAMES unless patch is None."""
    for k, pose in enumerate(poses):
        phantom_rng = (
            None if patch is None or k >= FRAMES else np.random.default_rng([7, seed, 0 if same else k])
        )
        rng = np.random.default_rng([5, seed, k])
        yield points_at(ROOM, pose, rng, (FRACTION, patch or 1), phantom_rng), view_at(pose)


def occupied_over(
    methods: dict[str, Method], frames: Iterator[tuple[NDArray[np.float32], SensorView]]
) -> dict[str, list[Dense]]:
    """Return what each method holds occupied after the first FRAMES and after all."""
    held: dict[str, list[Dense]] = {name: [] for name in methods}
    for k, (points, view) in enumerate(frames):
        for name, method in methods.items():
            method.add(PERIOD * k, points, view)
            if k + 1 in {FRAMES, 2 * FRAMES}:
                held[name].append(method.occupied())
    return held


def clean_run(
    methods: dict[str, Method], frames: Iterator[tuple[NDArray[np.float32], SensorView]]
) -> dict[str, CleanRun]:
    """Return what each method holds occupied ever and in the end."""
    runs: dict[str, CleanRun] = {}
    for k, (points, view) in enumerate(frames):
        for name, method in methods.items():
            method.add(PERIOD * k, points, view)
            now = method.occupied()
            runs[name] = CleanRun(now | runs[name].ever if k else now, now)
    return runs


def traversed_by_clean_frames(poses: list[SE2], shape: tuple[int, int, int], seed: int) -> Dense:
    """Return the voxels that rays of the last FRAMES passed."""
    passed, counter = np.zeros(shape, dtype=np.bool_), FrameVoxelizer(SETTINGS)
    for points, view in list(frames_of(poses, None, same=False, seed=seed))[FRAMES:]:
        frame = counter.count_and_trace(points, view)
        window = frame.window
        x, y, z = np.unravel_index(frame.traversed, (window.side, window.side, window.layers))
        x, y = x + (window.tile_x - FIRST_TILE) * TILE_SIZE, y + (window.tile_y - FIRST_TILE) * TILE_SIZE
        inside = (x >= 0) & (x < shape[0]) & (y >= 0) & (y < shape[1])
        passed[x[inside], y[inside], z[inside]] = True
    return passed


def score(held: list[Dense], clean: CleanRun, passed: Dense, solid: NDArray[np.bool_]) -> Scores:
    """Compare a run with the one without phantoms; solid has shape (side, side) along x and y."""
    spurious = [now & ~clean.ever & ~solid[..., None] for now in held]
    before, after = (cells_spurious.any(axis=2) & ~clean.ever.any(axis=2) for cells_spurious in spurious)
    with_rays = after & (spurious[1] & passed).any(axis=2)
    true = clean.last.any(axis=2) & solid
    lost = true & ~held[1].any(axis=2)
    return Scores(*(int(cells.sum()) for cells in (before, after, with_rays, true, lost)))


def print_table(
    drive: str, poses: list[SE2], solid: NDArray[np.bool_], seed: int, progress: tqdm[NoReturn]
) -> None:
    """Print the scores of all methods over one drive."""
    passed = traversed_by_clean_frames(poses, dense_shape(SETTINGS), seed)
    clean = clean_run(
        {name: make() for name, make in METHODS.items()}, frames_of(poses, None, same=False, seed=seed)
    )
    progress.update()
    print(f'\n### {drive}\n')
    print('| phantoms | method | false cells after the phantoms | left after clean frames | ', end='')
    print('of these with free rays | true cells | lost |\n|---|---|---|---|---|---|---|')
    for kind, (patch, same) in PHANTOMS.items():
        methods = {name: make() for name, make in METHODS.items()}
        held = occupied_over(methods, frames_of(poses, patch, same=same, seed=seed))
        progress.update()
        for name in methods:
            scores = score(held[name], clean[name], passed, solid)
            numbers = ' | '.join(str(number) for number in scores[:4])
            tqdm.write(f'| {kind} | {name} | {numbers} | {100.0 * scores.lost / max(scores.true, 1):.2f} % |')


def main() -> int:
    """Print the tables."""
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument('--seed', type=int, default=0, help='of noise and phantoms (default: 0)')
    seed = parser.parse_args().seed
    if not IS_INSTALLED:
        print(INSTALL)
    s = SETTINGS.resolution
    first = FIRST_TILE * TILE_SIZE * s
    heights = (SETTINGS.height_min, SETTINGS.height_max)
    solid = ROOM.solid_cells((first, first), s, (TILES * TILE_SIZE, TILES * TILE_SIZE), heights).T
    print('## Spurious obstacles\n\n`./shirube bench spurious_obstacles`')
    progress = tqdm(total=2 * (len(PHANTOMS) + 1), leave=False, desc='runs of 80 frames')
    for drive, poses in (
        ('Stationary robot', stationary_poses(2 * FRAMES)),
        ('Moving robot', moving_poses(2 * FRAMES)),
    ):
        print_table(drive, poses, solid, seed, progress)
    return 0


if __name__ == '__main__':
    raise SystemExit(main())
