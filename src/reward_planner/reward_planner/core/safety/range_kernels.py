"""Kernels of `RangeMemory`: bins of rays, cells seen free, and cells that are hit."""

import math
from typing import NamedTuple

import numpy as np
from numba import njit
from numpy.typing import NDArray

CELL = 0.05
"""Side of a cell [m]."""
BINS = 180
"""Bins of bearing, and half as many of elevation: 2 degrees each."""
NEVER = -1e18
"""Stamp of what has not happened."""
FREE, STATIC, UNSURE, MOVING = 0, 1, 2, 3
"""Classes of a cell: no obstacle; at rest; seen too shortly to know; entered space that was seen free."""
_WIDTH = math.tau / BINS
# Noise is hit for so long at most, and no more than so many cells from a surface that is older than this [s, cells, s].
_MOMENT, _NOISE_REACH, _SURFACE_TIME = 0.5, 3, 2.0
_PARTS = 3  # rays across a bin: no cell within 4 m is between them


class Cells(NamedTuple):
    """A square of cells that wraps around, arrays of shape (side, side); a key names the cell that an entry is of.

    Attributes: key; stamps [s] of the first and last hit, of the last ray through the column, of the last motion and of
    the last time at rest; x, y, z of the last hits and the heights that rays saw free [m]; class; whether it was first
    hit where somebody moved.
    """

    key: NDArray[np.int64]
    first: NDArray[np.float64]
    last: NDArray[np.float64]
    free: NDArray[np.float64]
    moved: NDArray[np.float64]
    rested: NDArray[np.float64]
    xyz: NDArray[np.float64]
    span: NDArray[np.float64]
    kind: NDArray[np.int8]
    arrived: NDArray[np.bool_]


class RayBins(NamedTuple):
    """Nearest ray end by bearing and elevation; by bearing the nearest hit, the span of the rays [m], their slopes."""

    nearest: NDArray[np.float64]
    hit: NDArray[np.float64]
    start: NDArray[np.float64]
    end: NDArray[np.float64]
    slopes: NDArray[np.float64]


@njit(cache=True)
def bin_rays(
    origin: NDArray[np.float64], ends: NDArray[np.float64], is_hit: NDArray[np.bool_], heights: tuple[float, float]
) -> RayBins:
    """Return the bins of rays, shape (n, 3), between two heights [m]."""
    nearest = np.full((BINS, BINS // 2 + 1), np.inf)
    hit, start, end = np.full(BINS, np.inf), np.full(BINS, np.inf), np.zeros(BINS)
    slopes = np.empty((BINS, 2))
    slopes[:, 0], slopes[:, 1] = np.inf, -np.inf
    for i in range(len(ends)):
        dx, dy, dz = ends[i, 0] - origin[0], ends[i, 1] - origin[1], ends[i, 2] - origin[2]
        flat = math.hypot(dx, dy)
        b, e = _bearing(dx, dy), _elevation(dz, flat)
        nearest[b, e] = min(nearest[b, e], math.hypot(flat, dz))
        slope = dz / max(flat, 1e-6)
        slopes[b, 0], slopes[b, 1] = min(slopes[b, 0], slope), max(slopes[b, 1], slope)
        if is_hit[i] and heights[0] <= ends[i, 2] <= heights[1]:
            hit[b] = min(hit[b], flat)
        # The part of the ray within the heights.
        low, high = 0.0, 1.0
        if dz != 0.0:
            one, two = (heights[0] - origin[2]) / dz, (heights[1] - origin[2]) / dz
            low, high = max(low, min(one, two)), min(high, max(one, two))
        if low < high and heights[0] <= origin[2] + low * dz + 1e-9 <= heights[1] + 2e-9:
            start[b], end[b] = min(start[b], low * flat), max(end[b], high * flat)
    return RayBins(nearest, hit, start, end, slopes)


@njit(cache=True)
def _bearing(dx: float, dy: float) -> int:
    return int((math.atan2(dy, dx) + math.pi) / _WIDTH) % BINS


@njit(cache=True)
def _elevation(dz: float, flat: float) -> int:
    return int((math.atan2(dz, flat) + 0.5 * math.pi) / _WIDTH + 0.5)


@njit(cache=True)
def _entry(cells: Cells, ix: int, iy: int) -> tuple[int, int]:
    """Return the entry of a cell; one that held another cell is emptied."""
    side = len(cells.key)
    i, j, key = ix % side, iy % side, ix * 1_000_003 + iy
    if cells.key[i, j] != key:
        cells.key[i, j] = key
        cells.first[i, j] = cells.last[i, j] = cells.free[i, j] = cells.moved[i, j] = NEVER
        cells.rested[i, j] = NEVER
        cells.kind[i, j], cells.arrived[i, j] = FREE, False
    return i, j


@njit(cache=True)
def carve(
    cells: Cells, bins: RayBins, origin: NDArray[np.float64], stamp: float, range_max: float, noise: float
) -> None:
    """Note which columns rays saw free, and between which heights."""
    for b in range(BINS):
        for part in range(_PARTS):
            angle = (b + (part + 0.5) / _PARTS) * _WIDTH - math.pi
            cos, sin = math.cos(angle), math.sin(angle)
            flat, end = bins.start[b], min(bins.end[b], range_max)
            while flat < end and flat < bins.hit[b] - _margin(flat, noise):
                ix, iy = (math.floor((origin[0] + flat * cos) / CELL), math.floor((origin[1] + flat * sin) / CELL))
                i, j = _entry(cells, ix, iy)
                cells.free[i, j] = stamp
                cells.span[i, j, 0] = origin[2] + flat * bins.slopes[b, 0]
                cells.span[i, j, 1] = origin[2] + flat * bins.slopes[b, 1]
                flat += CELL


@njit(cache=True)
def _margin(flat: float, noise: float) -> float:
    return 1.5 * CELL + 2.0 * noise * flat * flat


@njit(cache=True)
def clear(cells: Cells, bins: RayBins, origin: NDArray[np.float64], stamp: float, noise: float) -> None:
    """Forget obstacles that are not hit now where rays passed at their height."""
    side = len(cells.key)
    for i in range(side):
        for j in range(side):
            if NEVER < cells.last[i, j] < stamp:
                dx, dy = cells.xyz[i, j, 0] - origin[0], cells.xyz[i, j, 1] - origin[1]
                dz, flat = cells.xyz[i, j, 2] - origin[2], math.hypot(dx, dy)
                through = bins.nearest[_bearing(dx, dy), _elevation(dz, flat)]
                far, margin = math.hypot(flat, dz), _margin(flat, noise)
                # What moves is dropped where it is seen no more; what rests, where something behind it is seen.
                least = far + margin if cells.kind[i, j] == STATIC else far - margin
                is_noise = cells.kind[i, j] == STATIC and _is_noise_of_surface(cells, i, j, stamp)
                if least < through < math.inf or is_noise:
                    cells.first[i, j] = cells.last[i, j] = NEVER
                    cells.kind[i, j] = FREE


@njit(cache=True)
def _is_noise_of_surface(cells: Cells, i: int, j: int, stamp: float) -> bool:
    """Return whether a cell that was hit for a moment, long ago, is beside one that is hit now and has been for long.

    Far measurements of a wall are noisy, and near ones do not see all of its height again.
    """
    if cells.last[i, j] - cells.first[i, j] > _MOMENT or cells.last[i, j] > stamp - _SURFACE_TIME:
        return False
    side = len(cells.key)
    for a in range(-_NOISE_REACH, _NOISE_REACH + 1):
        for b in range(-_NOISE_REACH, _NOISE_REACH + 1):
            k, m = (i + a) % side, (j + b) % side
            if cells.last[k, m] == stamp and NEVER < cells.first[k, m] < stamp - _SURFACE_TIME:
                return True
    return False


@njit(cache=True)
def passed(bins: RayBins, origin: NDArray[np.float64], xy: NDArray[np.float64], noise: float) -> NDArray[np.bool_]:
    """Return which positions, shape (n, 2), rays passed within the heights without a hit before or at them."""
    is_open = np.zeros(len(xy), dtype=np.bool_)
    for n in range(len(xy)):
        dx, dy = xy[n, 0] - origin[0], xy[n, 1] - origin[1]
        b, flat = _bearing(dx, dy), math.hypot(dx, dy)
        far = flat + _margin(flat, noise)
        is_open[n] = bins.start[b] <= flat and min(bins.end[b], bins.hit[b]) > far
    return is_open


@njit(cache=True)
def insert(cells: Cells, ends: NDArray[np.float64], is_used: NDArray[np.bool_], stamp: float, points_min: int) -> None:
    """Add hits; a cell is hit if it and its eight neighbours have enough points."""
    side = len(cells.key)
    count, sums = np.zeros((side, side), dtype=np.int64), np.zeros((side, side, 3))
    for n in range(len(ends)):
        if is_used[n]:
            i = math.floor(ends[n, 0] / CELL) % side
            j = math.floor(ends[n, 1] / CELL) % side
            count[i, j] += 1
            sums[i, j] += ends[n]
    for i in range(side):
        for j in range(side):
            if count[i, j] == 0:
                continue
            around = 0
            for a in range(-1, 2):
                for b in range(-1, 2):
                    around += count[(i + a) % side, (j + b) % side]
            if around < points_min:
                continue
            mean = sums[i, j] / count[i, j]
            _entry(cells, math.floor(mean[0] / CELL), math.floor(mean[1] / CELL))
            if cells.last[i, j] == NEVER:
                cells.first[i, j] = stamp
            cells.last[i, j] = stamp
            cells.xyz[i, j] = mean
