"""Spurious obstacles that a map keeps, and real ones that it loses, beside OctoMap.

40 frames in which 3 % of the pixels show phantoms, then 40 clean ones. A false cell is occupied though nothing solid
is there, and never was so in a run of the same method on the same frames without phantoms (noise of the depth thickens
walls in any case). It had free rays if a clean frame's rays passed one of its false voxels. A true cell is solid and
occupied in the run without phantoms. Settings are the defaults, which `voxel_speed` uses too.
"""

from collections.abc import Callable, Container, Iterator

import numpy as np
from _figures import count, rate
from _harness import Option, Run, progress, run_benchmark
from _mapping_methods import FIRST_TILE, PYOCTOMAP, TILES, Dense, Method, OctoMap, Voxels, dense_shape
from _voxel_scenes import ROOM, moving_poses, points_at, stationary_poses, view_at
from numpy.typing import NDArray

from reward_planner.core.settings import VoxelSettings
from reward_planner.core.voxels.frame_voxels import FrameVoxelizer
from reward_planner.core.voxels.rolling_voxel_grid import TILE_SIZE, SensorView
from shirube_core.geometry import SE2

FRACTION = 0.03
PERIOD = 0.1
SETTINGS = VoxelSettings()
METHODS: dict[str, Callable[[], Method]] = {
    'the paper: `count`, mean over time': lambda: Voxels(VoxelSettings(rule='count')),
    '`range_normalised`, mean over time': lambda: Voxels(VoxelSettings(rule='range_normalised')),
    '`log_odds`': lambda: Voxels(SETTINGS),
}
PHANTOMS = {
    'single points, new ones in each frame': (1, False),
    'patches of 8 x 8, new ones in each frame': (8, False),
    'patches of 24 x 24, new ones in each frame': (24, False),
    'patches of 24 x 24, the same in all frames': (24, True),
}

Frames = Iterator[tuple[NDArray[np.float32], SensorView]]


def frames_of(poses: list[SE2], patch: int | None, *, same: bool, seed: int) -> Frames:
    """Yield the frames of a run, with phantoms in the first half unless patch is None."""
    for k, pose in enumerate(poses):
        is_clean = patch is None or 2 * k >= len(poses)
        phantom_rng = None if is_clean else np.random.default_rng([7, seed, 0 if same else k])
        rng = np.random.default_rng([5, seed, k])
        yield points_at(ROOM, pose, rng, (FRACTION, patch or 1), phantom_rng), view_at(pose)


def occupied_after(methods: dict[str, Method], frames: Frames, wanted: Container[int]) -> Iterator[tuple[str, Dense]]:
    """Yield what each method holds occupied after the wanted numbers of frames."""
    for k, (points, view) in enumerate(frames):
        for name, method in methods.items():
            method.add(PERIOD * k, points, view)
            if k + 1 in wanted:
                yield name, method.occupied()


def traversed_by_clean_frames(poses: list[SE2], seed: int) -> Dense:
    """Return the voxels that rays of the second half of the frames passed."""
    shape = dense_shape(SETTINGS)
    passed, counter = np.zeros(shape, dtype=np.bool_), FrameVoxelizer(SETTINGS)
    for points, view in list(frames_of(poses, None, same=False, seed=seed))[len(poses) // 2 :]:
        frame = counter.count_and_trace(points, view)
        window = frame.window
        x, y, z = np.unravel_index(frame.traversed, (window.side, window.side, window.layers))
        x, y = x + (window.tile_x - FIRST_TILE) * TILE_SIZE, y + (window.tile_y - FIRST_TILE) * TILE_SIZE
        inside = (x >= 0) & (x < shape[0]) & (y >= 0) & (y < shape[1])
        passed[x[inside], y[inside], z[inside]] = True
    return passed


def solid_cells() -> NDArray[np.bool_]:
    """Return the cells of the room that are solid, shape (side, side) along x and y."""
    first, size = FIRST_TILE * TILE_SIZE * SETTINGS.resolution, TILES * TILE_SIZE
    heights = SETTINGS.height_min, SETTINGS.height_max
    return ROOM.solid_cells((first, first), SETTINGS.resolution, (size, size), heights).T


def main(run: Run, frames: int) -> None:
    """Map with all methods."""
    methods, solid = dict(METHODS), solid_cells()
    pyoctomap = run.peer(*PYOCTOMAP)
    if pyoctomap is not None:
        methods['pyoctomap'] = lambda: OctoMap(pyoctomap, SETTINGS)

    def new_methods() -> dict[str, Method]:
        return {name: make() for name, make in methods.items()}

    heads = 'phantoms | method | false cells after the phantoms | left after clean frames | of these with free rays'
    drives = {'Stationary robot': stationary_poses(2 * frames), 'Moving robot': moving_poses(2 * frames)}
    for drive, poses in drives.items():
        passed = traversed_by_clean_frames(poses, run.seed)
        clean_frames = frames_of(poses, None, same=False, seed=run.seed)
        ever, last = dict[str, Dense](), dict[str, Dense]()  # without phantoms
        for name, now in occupied_after(new_methods(), clean_frames, range(2 * frames + 1)):
            ever[name], last[name] = ever.get(name, now) | now, now
        table = run.table(drive, heads, 'true cells lost')
        for kind, (patch, same) in progress(PHANTOMS.items(), drive):
            spoilt = frames_of(poses, patch, same=same, seed=run.seed)
            held = list(occupied_after(new_methods(), spoilt, (frames, 2 * frames)))
            for (name, first), (_, end) in zip(held[: len(methods)], held[len(methods) :], strict=True):
                spurious = [now & ~ever[name] & ~solid[..., None] for now in (first, end)]
                before, after = (each.any(axis=2) & ~ever[name].any(axis=2) for each in spurious)
                with_rays = after & (spurious[1] & passed).any(axis=2)
                true = last[name].any(axis=2) & solid
                lost = true & ~end.any(axis=2)
                numbers = (count(int(cells.sum()), better='lower') for cells in (before, after, with_rays))
                table.add(kind, name, *numbers, rate(int(lost.sum()), int(true.sum()), 'lower'))


if __name__ == '__main__':
    run_benchmark(main, frames=Option(40, 5, 'with phantoms, and as many without'))
