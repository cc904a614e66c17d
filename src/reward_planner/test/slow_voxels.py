"""Reference implementation of voxels and rays in plain Python."""

import itertools
import math

import numpy as np

Voxel = tuple[int, int, int]


def voxel_of(point, resolution, bottom) -> Voxel:
    """The voxel of a point; voxel (0, 0, 0) starts at (0, 0, bottom)."""
    return tuple(math.floor(c / resolution) for c in (point[0], point[1], point[2] - bottom))


def centre_of(voxel, resolution, bottom):
    """The centre of a voxel."""
    return (np.array(voxel) + 0.5) * resolution + (0.0, 0.0, bottom)


def voxels_on_segment(start, end, resolution, bottom) -> set[Voxel]:
    """All voxels that a segment traverses: split it at every face and take the middle of each part."""
    low = (np.array(start) - (0.0, 0.0, bottom)) / resolution
    high = (np.array(end) - (0.0, 0.0, bottom)) / resolution
    cuts = {0.0, 1.0}
    for a, b in zip(low, high):
        for face in range(math.ceil(min(a, b)), math.floor(max(a, b)) + 1):
            if a != b:
                cuts.add((face - a) / (b - a))
    ordered = sorted(cut for cut in cuts if 0.0 <= cut <= 1.0)
    pieces = [(a, b) for a, b in itertools.pairwise(ordered) if b - a > 1e-9]
    return {tuple(np.floor(low + 0.5 * (a + b) * (high - low)).astype(int).tolist()) for a, b in pieces}


def cells_as_voxels(cells, window) -> list[Voxel]:
    """Flat indices of a window as voxels of the map."""
    columns, rows = cells // (window.side * window.layers), cells // window.layers % window.side
    first = np.array([window.tile_x, window.tile_y, 0]) * 16
    return [tuple(v) for v in (np.column_stack([columns, rows, cells % window.layers]) + first).tolist()]
