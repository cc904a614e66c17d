"""Which voxels that are truly filled each rule keeps, near and far: `./shirube bench range_bias`.

Single frames of 272 000 points of scenes with boxes at random places 0.8 to 4 m ahead. A voxel is truly filled if a
camera without noise finds there more than half of the points that a surface across it gives. Kept is what has a value
of `value_min` or more.
"""

from __future__ import annotations

import argparse

import numpy as np
from _voxel_scenes import CAMERA, points_at, view_at
from tqdm import tqdm

from reward_planner.core.voxels.frame_voxels import FrameVoxelizer
from reward_planner.core.voxels.voxel_map import counts_over_expected, counts_over_maximum
from reward_planner.core.voxels.voxel_settings import VoxelSettings
from scene_simulator.box_room import BoxRoom, points_from_depth
from shirube_core.geometry import SE2

RANGES = ((0.8, 1.5), (1.5, 2.2), (2.2, 3.0), (3.0, 4.0))
SCENES = 40
BOXES = 6


def scene(rng: np.random.Generator) -> BoxRoom:
    """Return a hall with boxes ahead of its origin."""
    boxes = []
    for x, bearing, width, height in zip(
        rng.uniform(0.8, 4.0, BOXES),
        rng.uniform(-0.5, 0.5, BOXES),
        rng.uniform(0.2, 0.6, BOXES),
        rng.uniform(0.4, 1.2, BOXES),
        strict=True,
    ):
        y = x * bearing
        boxes.append((x, y - width / 2.0, 0.0, x + 0.3, y + width / 2.0, height))
    return BoxRoom((-1.0, -4.0, 0.0, 6.0, 4.0, 2.6), tuple(boxes))


def main() -> int:
    """Print the table."""
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.parse_args()
    print('## Bias against far voxels\n\n`./shirube bench range_bias`\n')
    print(
        '| voxels m | filled voxels at m | number | `count` keeps | `range_normalised` keeps |\n|---|---|---|---|---|'
    )
    for resolution in (0.1, VoxelSettings().resolution):
        settings = VoxelSettings(resolution=resolution)
        counter, rows = FrameVoxelizer(settings), []
        pose = SE2(0.0, 0.0, 0.0)
        view = view_at(pose)
        for k in tqdm(range(SCENES), leave=False):
            rng = np.random.default_rng(k)
            room = scene(rng)
            clean = points_from_depth(room.depth_image(CAMERA, view.T_map_sensor), CAMERA)
            exact, frame = counter.count(clean, view), counter.count(points_at(room, pose, rng), view)
            filled = exact.counts > 0.5 * exact.expected
            values = np.zeros((exact.window.side**2 * exact.window.layers, 2))
            values[frame.cells, 0] = counts_over_maximum(frame.counts)
            values[frame.cells, 1] = counts_over_expected(frame.counts, frame.expected)
            depths = resolution * CAMERA.fx / np.sqrt(exact.expected[filled])
            rows.append(np.column_stack([depths, values[exact.cells[filled]]]))
        table = np.concatenate(rows)
        for near, far in RANGES:
            inside = table[(table[:, 0] >= near) & (table[:, 0] < far), 1:]
            kept = 100.0 * (inside >= settings.value_min).mean(axis=0)
            print(f'| {resolution} | {near}-{far} | {len(inside)} | {kept[0]:.0f} % | {kept[1]:.0f} % |')
    return 0


if __name__ == '__main__':
    raise SystemExit(main())
