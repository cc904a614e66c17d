"""One frame of points as voxels: which are hit, how often, and which are passed by rays."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np
from numba import njit
from numpy.typing import ArrayLike, NDArray

from reward_planner.core.voxels.count_points import PointTally, count_open_ends, count_points
from reward_planner.core.voxels.frame_window import FrameWindow, place_of_cell, window_around, window_shape
from reward_planner.core.voxels.free_rays import ENDED, mark_ends_passed, mark_passed
from reward_planner.core.voxels.sensor_view import SensorView
from reward_planner.core.voxels.voxel_error import VoxelError
from reward_planner.core.voxels.voxel_settings import VoxelSettings

_OPEN_END_POINTS = 2
"""Rays that leave the window free what they pass if so many end in the same voxel; one alone may be a phantom."""


@dataclass(frozen=True)
class FrameVoxels:
    """The voxels of a frame; cells are flat indices in the window.

    Attributes:
        window: the box of voxels.
        cells: shape (k,), voxels in which points lie.
        counts: shape (k,), how many.
        expected: shape (k,), how many a surface that fills the voxel would give, 0 where the density is not known.
        passed: shape (m,), voxels that only rays went through; empty unless rays were asked for.
        tally: what became of the points.
    """

    window: FrameWindow
    cells: NDArray[np.int32]
    counts: NDArray[np.int32]
    expected: NDArray[np.float64]
    passed: NDArray[np.int32]
    tally: PointTally


class FrameCounter:
    """Makes voxels of frames; holds the work space, whose size does not depend on the points."""

    def __init__(self, settings: VoxelSettings) -> None:
        """Reserve the work space.

        Raises:
            VoxelError: the settings leave no voxels.
        """
        self._settings = settings
        side, layers = window_shape(settings)
        shape = (side, side, layers)
        self._counts = np.zeros(shape, dtype=np.int32)
        self._marks = np.zeros(shape, dtype=np.uint8)
        self._cells = np.empty(self._counts.size, dtype=np.int32)
        self._passed = np.empty(self._counts.size, dtype=np.int32)

    def count(self, points: ArrayLike, view: SensorView) -> FrameVoxels:
        """Count points into voxels (2.2.2, step 1).

        Args:
            points: array-like, shape (n, 3), in the sensor frame [m]; NaN and infinite ones are dropped.
            view: where the sensor is.

        Raises:
            VoxelError: points of another shape.
        """
        return self._count(_as_points(points), view, window_around(view, self._settings))

    def count_and_trace(self, points: ArrayLike, view: SensorView) -> FrameVoxels:
        """Count points and find what rays passed; arguments and errors as of `count`.

        Rays end in voxels with a share ``hit_share_min`` of the expected points. Voxels with fewer are neither hit
        nor passed, and what lies behind them is not free because of them.
        """
        cloud, window = _as_points(points), window_around(view, self._settings)
        try:
            return self._trace(cloud, view, self._count(cloud, view, window))
        except BaseException:  # what is left in the work space would be taken for the next frame's
            self._counts.fill(0)
            self._marks.fill(0)
            raise

    @property
    def _ranges(self) -> tuple[float, float]:
        return self._settings.range_min, self._settings.range_max

    def _trace(self, cloud: NDArray[np.float32], view: SensorView, frame: FrameVoxels) -> FrameVoxels:
        """Return the frame with what rays passed."""
        window = frame.window
        hits = is_hit(frame, self._settings.hit_share_min)
        T = _window_from_sensor(view, window)
        opened = count_open_ends(cloud, T, self._ranges, self._counts, self._cells)
        open_cells = self._cells[:opened]
        open_counts = take_counts(open_cells, self._counts)
        fewest = _OPEN_END_POINTS if view.focal_length > 0.0 else 1
        open_ends = open_cells[open_counts >= fewest]
        origin = (view.origin - window.corner) / window.resolution
        marks = self._marks.reshape(-1)
        marks[frame.cells] = ENDED
        count = mark_passed(frame.cells[hits], origin, self._marks, self._passed, 0)
        count = mark_passed(open_ends, origin, self._marks, self._passed, count)
        count = mark_ends_passed(open_ends, self._marks, self._passed, count)
        passed = self._passed[:count].copy()
        marks[frame.cells] = 0
        marks[passed] = 0
        return replace(frame, passed=passed)

    def _count(self, cloud: NDArray[np.float32], view: SensorView, window: FrameWindow) -> FrameVoxels:
        T = _window_from_sensor(view, window)
        filled, tally = count_points(cloud, T, self._ranges, self._counts, self._cells)
        cells = self._cells[:filled].copy()
        counts = take_counts(cells, self._counts)
        expected = expected_points(cells, window, T, view.focal_length)
        return FrameVoxels(window, cells, counts, expected, np.empty(0, dtype=np.int32), tally)


def is_hit(frame: FrameVoxels, share: float) -> NDArray[np.bool_]:
    """Return which voxels with points have a share of the expected ones, shape (k,)."""
    return frame.counts >= np.maximum(share * frame.expected, 1.0)


@njit(cache=True)
def take_counts(cells: NDArray[np.int32], counts: NDArray[np.int32]) -> NDArray[np.int32]:
    """Return the counts of cells, shape (k,), and set them to 0."""
    flat = counts.reshape(-1)
    taken = np.empty(len(cells), dtype=np.int32)
    for i, cell in enumerate(cells):
        taken[i] = flat[cell]
        flat[cell] = 0
    return taken


@njit(cache=True)
def expected_points(
    cells: NDArray[np.int32], window: FrameWindow, T_window_sensor: NDArray[np.float64], focal_length: float
) -> NDArray[np.float64]:
    """Return how many points a surface across a voxel gives, (f s / Z)^2, shape (k,).

    Args:
        cells: shape (k,), flat indices in the window.
        window: the box of voxels.
        T_window_sensor: shape (3, 4), from the sensor frame to voxels from the window's corner.
        focal_length: f, points per unit of the tangent.
    """
    axis = T_window_sensor[:, 2] * window.resolution  # of unit length
    start = T_window_sensor[:, 3]
    expected = np.empty(len(cells))
    for i, cell in enumerate(cells):
        column, row, layer = place_of_cell(cell, window.side, window.layers)
        depth = (
            axis[0] * (column + 0.5 - start[0])
            + axis[1] * (row + 0.5 - start[1])
            + axis[2] * (layer + 0.5 - start[2])
        )
        expected[i] = (focal_length / max(depth, 1.0)) ** 2
    return expected


def _window_from_sensor(view: SensorView, window: FrameWindow) -> NDArray[np.float64]:
    """Return the (3, 4) transform from the sensor frame to voxels from the window's corner."""
    T = view.T_map_sensor[:3].copy()
    T[:, 3] -= window.corner
    return T / window.resolution


def _as_points(points: ArrayLike) -> NDArray[np.float32]:
    cloud = np.ascontiguousarray(points, dtype=np.float32)
    if cloud.ndim != 2 or cloud.shape[1] != 3:
        raise VoxelError(f'points have the shape {cloud.shape}; give one row x, y, z a point')
    return cloud
