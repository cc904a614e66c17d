"""Voxels of one frame: hit voxels with their counts, and voxels traversed by rays."""

from dataclasses import dataclass, replace

import numpy as np
from numba import njit
from numpy.typing import ArrayLike, NDArray

from reward_planner.core.reward_planner_error import RewardPlannerError
from reward_planner.core.settings import VoxelSettings
from reward_planner.core.voxels.frame_kernels import (
    HIT,
    UNSEEN,
    PointCounts,
    count_points,
    count_ray_exits,
    mark_traversed,
    mark_traversed_exits,
)
from reward_planner.core.voxels.rolling_voxel_grid import (
    FrameWindow,
    SensorView,
    check_voxel_settings,
    unravel_cell,
    window_around,
    window_shape,
)

_EXIT_RAYS_MIN = 2  # rays through the same exit voxel that clear voxels, if so many are expected: one may be noise


@dataclass(frozen=True)
class FrameVoxels:
    """Voxels of a frame; cells are flat indices in the window.

    Attributes:
        window: box of voxels.
        cells: voxels with points, shape (k,).
        counts: number of points in each, shape (k,).
        expected: number of points that a surface filling the voxel gives, 0 for unknown density, shape (k,).
        traversed: voxels that rays traversed and no point hit, shape (m,); empty without ray tracing.
        point_counts: number of points by outcome.
    """

    window: FrameWindow
    cells: NDArray[np.int32]
    counts: NDArray[np.int32]
    expected: NDArray[np.float64]
    traversed: NDArray[np.int32]
    point_counts: PointCounts


class FrameVoxelizer:
    """Converts frames to voxels by its ``settings``; owns the work space, whose size does not depend on the points."""

    def __init__(self, settings: VoxelSettings) -> None:
        """Allocate the work space; errors are those of `check_voxel_settings`."""
        check_voxel_settings(settings)
        self.settings = settings
        self._ranges = settings.range_min, settings.range_max
        side, layers = window_shape(settings)
        self._counts = np.zeros((side, side, layers), dtype=np.int32)
        self._marks = np.zeros(self._counts.shape, dtype=np.uint8)
        self._cells = np.empty(self._counts.size, dtype=np.int32)
        self._traversed = np.empty(self._counts.size, dtype=np.int32)

    def count(self, points: ArrayLike, view: SensorView) -> FrameVoxels:
        """Count points into voxels (2.2.2, step 1).

        Points are in the sensor frame [m], array-like, shape (n, 3); NaN and infinite ones are dropped.

        Raises:
            RewardPlannerError: points of a wrong shape.
        """
        window = window_around(view, self.settings)
        T = _window_from_sensor(view, window)
        filled, point_counts = count_points(as_points(points), T, self._ranges, self._counts, self._cells)
        cells = self._cells[:filled].copy()
        counts = pop_counts(cells, self._counts)
        expected = expected_points(cells, window, T, view.focal_length)
        return FrameVoxels(window, cells, counts, expected, np.empty(0, dtype=np.int32), point_counts)

    def count_and_trace(self, points: ArrayLike, view: SensorView) -> FrameVoxels:
        """Count points and trace their rays; arguments and errors as for `count`.

        Rays end in voxels with at least the fraction ``hit_fraction_min`` of the expected points. Voxels with fewer are
        neither hit nor traversed, and clear nothing behind them.
        """
        try:
            return self._trace(as_points(points), view, self.count(points, view))
        except BaseException:  # remains in the work space would count for the next frame
            self._counts.fill(0)
            self._marks.fill(0)
            raise

    def _trace(self, cloud: NDArray[np.float32], view: SensorView, frame: FrameVoxels) -> FrameVoxels:
        """Return the frame with the voxels that rays traversed."""
        window, marks = frame.window, self._marks.reshape(-1)
        # Rays end in hit voxels, or where enough of them leave the window.
        T = _window_from_sensor(view, window)
        exit_count = count_ray_exits(cloud, T, self._ranges, self._counts, self._cells)
        exit_cells = self._cells[:exit_count]
        exit_rays = expected_points(exit_cells, window, T, view.focal_length)
        rays_min = np.clip(exit_rays, 1.0, _EXIT_RAYS_MIN)
        exits = exit_cells[pop_counts(exit_cells, self._counts) >= rays_min]
        ends = frame.cells[is_hit(frame, self.settings.hit_fraction_min)]
        # One ray for each end marks the voxels on its way; those with points stay unmarked.
        origin = (view.origin - window.corner) / window.resolution
        marks[frame.cells] = HIT
        count = mark_traversed(ends, origin, self._marks, self._traversed, 0)
        count = mark_traversed(exits, origin, self._marks, self._traversed, count)
        count = mark_traversed_exits(exits, self._marks, self._traversed, count)
        traversed = self._traversed[:count].copy()
        marks[frame.cells] = marks[traversed] = 0
        return replace(frame, traversed=traversed)

    def with_passed(self, frame: FrameVoxels, passed: NDArray[np.int32]) -> FrameVoxels:
        """Return the frame with more traversed voxels, shape (n,), those with points left out."""
        marks = self._marks.reshape(-1)
        marks[frame.cells] = marks[frame.traversed] = HIT
        new = passed[marks[passed] == UNSEEN]
        marks[frame.cells] = marks[frame.traversed] = UNSEEN
        return replace(frame, traversed=np.concatenate([frame.traversed, new]))


def is_hit(frame: FrameVoxels, fraction: float) -> NDArray[np.bool_]:
    """Return which voxels have at least a fraction of their expected points, shape (k,)."""
    return frame.counts >= np.maximum(fraction * frame.expected, 1.0)


@njit(cache=True)
def pop_counts(cells: NDArray[np.int32], counts: NDArray[np.int32]) -> NDArray[np.int32]:
    """Return the counts of cells, shape (k,), and reset them to 0."""
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
    """Return the number of points that a surface across a voxel gives, (f s / Z)^2, shape (k,).

    Cells are flat indices, shape (k,); f is the focal length. The transform leads to voxels from the window's corner.
    """
    axis = T_window_sensor[:, 2] * window.resolution  # of unit length
    start = T_window_sensor[:, 3]
    expected = np.empty(len(cells))
    for i, cell in enumerate(cells):
        column, row, layer = unravel_cell(cell, window.side, window.layers)
        depth = (
            axis[0] * (column + 0.5 - start[0]) + axis[1] * (row + 0.5 - start[1]) + axis[2] * (layer + 0.5 - start[2])
        )
        expected[i] = (focal_length / max(depth, 1.0)) ** 2
    return expected


def _window_from_sensor(view: SensorView, window: FrameWindow) -> NDArray[np.float64]:
    """Return the (3, 4) transform from the sensor frame to voxels from the window's corner."""
    T = view.T_map_sensor[:3].copy()
    T[:, 3] -= window.corner
    return T / window.resolution


def as_points(points: ArrayLike) -> NDArray[np.float32]:
    """Return points as a contiguous array, shape (n, 3); raise a RewardPlannerError for other shapes."""
    cloud = np.ascontiguousarray(points, dtype=np.float32)
    if cloud.ndim != 2 or cloud.shape[1] != 3:
        raise RewardPlannerError(f'points have the shape {cloud.shape}; give one row x, y, z per point')
    return cloud
