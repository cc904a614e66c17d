"""The costmap of the route search: distance of each cell to the nearest obstacle, and the inflated obstacles."""

import math

import cv2
import numpy as np
from numpy.typing import ArrayLike, NDArray

from reward_planner.core.mapping.global_map import GlobalMap
from reward_planner.core.occupancy_map import OCCUPIED_THRESHOLD, UNKNOWN, GridFrame, clearance
from reward_planner.core.reward_planner_error import DrivingError
from reward_planner.core.route.route import COST_MAX, LETHAL, inflation_costs
from reward_planner.core.safety.footprint import Footprint
from reward_planner.core.settings import PlannerSettings

_GROWTH_STEP = 64  # size steps of the costmap [cells], so that it is not resized with each new cell
_WINDOW_MARGIN = 5.0  # least margin around robot and goal on a map that is too large [m]
_PLAIN = PlannerSettings(cost_scaling_factor=0.0)
_OBSTACLE_DEPTH = 0.5  # what is seen may extend so far into unknown cells behind it [m]


class InflatedCostmap:
    """A rectangle around all known cells, the robot and the goal.

    It has a margin that a robot can drive along, so that routes around the known cells are found. On maps of more than
    cells_max cells it covers a part.

    Attributes:
        frame: origin, resolution and size of the grid.
        clearance: distance to the nearest obstacle, at most ``clearance_max`` [m], shape (rows, columns); 0 in
            keep-out areas.
        cautious_clearance: the same, also to unknown cells behind obstacles.
        costs: costs of the cells as in Nav2, see `inflation_costs` and `CostmapMasks`; uint8, shape (rows, columns).
            Those of unknown cells behind obstacles are as if these extended there, but not lethal.
        blocked: cells that routes do not enter, shape (rows, columns): within ``inscribed_radius`` of an obstacle, in
            a keep-out area, and the unknown ones if the settings block them.
        inscribed_radius: least distance of a route from obstacles [m].
        clearance_max: largest clearance that is computed [m].
    """

    def __init__(self, inscribed_radius: float, clearance_max: float, settings: PlannerSettings = _PLAIN) -> None:
        """Start with one cell; ``clearance_max`` is at least the inscribed and the settings' inflation radius."""
        self.inscribed_radius, self.clearance_max = inscribed_radius, clearance_max
        self._settings = settings
        self._keepout: NDArray[np.uint8] | None = None
        self._allocate(GridFrame(0.0, 0.0, 1.0, 1, 1))

    def _allocate(self, frame: GridFrame) -> None:
        self.frame = frame
        self.clearance = np.full(frame.shape, self.clearance_max, dtype=np.float32)
        self.cautious_clearance = self.clearance.copy()
        self.costs = np.zeros(frame.shape, dtype=np.uint8)
        self.blocked = np.zeros(frame.shape, dtype=np.bool_)

    def cover(self, global_map: GlobalMap, points_map: ArrayLike) -> bool:
        """Resize the costmap to cover a map and points [m], shape (n, 2); return whether it was resized.

        It keeps what it covered before while cells_max allows that. On a larger map it covers a part around the
        points.

        Raises:
            DrivingError: the points are too far apart.
        """
        frame = required_frame(global_map, points_map, self.inscribed_radius)
        if frame.size > global_map.cells_max:
            minimal = _frame_around(*_bounds(points_map), _WINDOW_MARGIN, global_map.resolution)
            if minimal.size > global_map.cells_max:
                raise DrivingError(
                    f'the route needs {minimal.columns} x {minimal.rows} cells, cells_max is {global_map.cells_max}; '
                    'give a nearer goal or a larger resolution'
                )
            if _contains(self.frame, minimal):
                return False
            frame = _expand(minimal, global_map.cells_max)
        elif _contains(self.frame, frame):
            return False
        else:
            union = _union(self.frame, frame)
            frame = union if union.size <= global_map.cells_max else frame
        self.cover_frame(global_map, frame)
        return True

    def cover_frame(self, global_map: GlobalMap, frame: GridFrame) -> None:
        """Cover a frame of the map's resolution, and nothing else."""
        self._allocate(frame)
        self._keepout = global_map.masks.keepout_costs(frame)
        self.refresh(global_map, frame)

    def refresh(self, global_map: GlobalMap, changed: GridFrame) -> NDArray[np.int64]:
        """Update the costmap where the map changed; return the cells whose cost changed, shape (n, 2)."""
        resolution = self.frame.resolution
        pad = math.ceil((self.clearance_max + _OBSTACLE_DEPTH) / resolution) + 1
        corner = np.array([changed.origin_y, changed.origin_x])
        origin = np.array([self.frame.origin_y, self.frame.origin_x])
        low = np.round((corner - origin) / resolution).astype(np.int64) - pad
        first = np.maximum(low, 0)
        size = np.array(changed.shape) + 2 * pad
        last = np.minimum(low + size, self.frame.shape)
        if (last <= first).any():
            return np.empty((0, 2), dtype=np.int64)
        part = (slice(first[0], last[0]), slice(first[1], last[1]))
        distances, cautious, is_unknown = self._distances(global_map, first, last, pad)
        costs = inflation_costs(distances, self.inscribed_radius, self._settings)
        if self._settings.cost_scaling_factor > 0.0:
            behind = inflation_costs(cautious, self.inscribed_radius, self._settings)
            np.maximum(costs, np.minimum(behind, COST_MAX), out=costs)
        if self._settings.unknown == 'blocked':
            costs[is_unknown] = LETHAL
        if self._keepout is not None:
            np.maximum(costs, self._keepout[part], out=costs)
            distances[self._keepout[part] > COST_MAX] = 0.0
        cells = np.argwhere(costs != self.costs[part]) + first
        self.clearance[part], self.cautious_clearance[part] = distances, np.minimum(distances, cautious)
        self.costs[part], self.blocked[part] = costs, costs > COST_MAX
        return cells

    def clearance_at(self, points_map: ArrayLike, *, is_cautious: bool = False) -> NDArray[np.float32]:
        """Return the clearance at points of shape (..., 2), shape (...) [m]; ``clearance_max`` outside."""
        clearance = self.cautious_clearance if is_cautious else self.clearance
        cells = self.frame.cell_of(points_map)
        inside = self.frame.contains(cells)
        rows, columns = np.where(inside[..., None], cells, 0).T
        return np.asarray(np.where(inside.T, clearance[rows, columns], self.clearance_max).T, dtype=np.float32)

    def _distances(
        self, global_map: GlobalMap, first: NDArray[np.int64], last: NDArray[np.int64], pad: int
    ) -> tuple[NDArray[np.float32], NDArray[np.float32], NDArray[np.bool_]]:
        """Return both clearances of cells [first, last), from obstacles up to ``pad`` outside; and the unknown."""
        resolution = self.frame.resolution
        rows, columns = (int(n) for n in last - first + 2 * pad)
        origin_y, origin_x = (self.frame.origin_y, self.frame.origin_x) + resolution * (first - pad)
        frame = GridFrame(float(origin_x), float(origin_y), resolution, columns, rows)
        occupancy = global_map.occupancy_in(frame)
        inner = (slice(pad, rows - pad), slice(pad, columns - pad))
        occupied, unknown = occupancy >= OCCUPIED_THRESHOLD, occupancy == UNKNOWN
        both = occupied, extend_into(unknown, occupied, math.ceil(_OBSTACLE_DEPTH / resolution))
        near, cautious = (np.minimum(clearance(each, resolution)[inner], self.clearance_max) for each in both)
        return near, cautious, unknown[inner]


def extend_into(unknown: NDArray[np.bool_], occupied: NDArray[np.bool_], cells: int) -> NDArray[np.bool_]:
    """Return the occupied cells and unknown ones that a way through unknown cells, so long, connects to them."""
    extended, allowed = occupied.astype(np.uint8), (occupied | unknown).astype(np.uint8)
    for step in range(cells if occupied.any() and unknown.any() else 0):
        # The cross and the square in turn come near to a disc.
        kernel = cv2.getStructuringElement((cv2.MORPH_CROSS, cv2.MORPH_RECT)[step % 2], (3, 3))
        extended = np.minimum(cv2.dilate(extended, kernel), allowed)
    return extended > 0


def required_frame(global_map: GlobalMap, points_map: ArrayLike, inscribed_radius: float) -> GridFrame:
    """Return the smallest frame around a map and some points; arguments as for `InflatedCostmap`."""
    low, high = _bounds(points_map)
    known_frame = global_map.frame()
    if known_frame is not None:
        corner, end = known_frame.corners
        low, high = np.minimum(low, corner), np.maximum(high, end)
    return _frame_around(low, high, inscribed_radius + 2.0 * global_map.resolution, global_map.resolution)


def _bounds(points_map: ArrayLike) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    points = np.asarray(points_map, dtype=np.float64)
    return points.min(axis=0), points.max(axis=0)


def _frame_around(low: NDArray[np.float64], high: NDArray[np.float64], margin: float, resolution: float) -> GridFrame:
    """Return the frame between two corners [m] with a margin [m], aligned to the growth steps."""
    step = _GROWTH_STEP * resolution
    return _frame_from_steps(np.floor((low - margin) / step), np.ceil((high + margin) / step), resolution)


def _expand(frame: GridFrame, cells_max: int) -> GridFrame:
    """Return a frame grown on all sides to about half of cells_max."""
    # Solve (columns + 2 g) (rows + 2 g) = cells_max / 2 for g.
    columns, rows = frame.columns, frame.rows
    half = 0.25 * (columns + rows)
    growth = math.sqrt(max(half**2 - 0.25 * (columns * rows - 0.5 * cells_max), half**2)) - half
    low, high = frame.corners
    return _frame_around(low, high, max(growth - _GROWTH_STEP, 0.0) * frame.resolution, frame.resolution)


def _union(frame: GridFrame, other: GridFrame) -> GridFrame:
    """Return the smallest frame around both, or the other one if their resolutions differ."""
    if frame.resolution != other.resolution:
        return other
    step = _GROWTH_STEP * frame.resolution
    (low, high), (other_low, other_high) = frame.corners, other.corners
    first, last = np.minimum(low, other_low) / step, np.maximum(high, other_high) / step
    return _frame_from_steps(np.round(first), np.round(last), frame.resolution)


def _frame_from_steps(first: NDArray[np.float64], last: NDArray[np.float64], resolution: float) -> GridFrame:
    """Return the frame between two corners [growth steps]."""
    step = _GROWTH_STEP * resolution
    columns, rows = (_GROWTH_STEP * int(n) for n in last - first)
    return GridFrame(float(first[0] * step), float(first[1] * step), resolution, columns, rows)


def _contains(frame: GridFrame, other: GridFrame) -> bool:
    if frame.resolution != other.resolution:
        return False
    half = 0.5 * other.resolution
    low, high = other.corners
    return bool(frame.contains(frame.cell_of([low + half, high - half])).all())


_CELL_MARGIN = 0.75  # from the centre of an occupied cell to its edge, rounded up [cells]


class FootprintCheck:
    """Points that fill a footprint, to be looked up in a costmap.

    Attributes:
        clearance_min: clearance above which the footprint is free in every direction [m].
    """

    def __init__(self, footprint: Footprint, resolution: float) -> None:
        """Take a footprint, and the side of the costmap's cells [m]."""
        self._margin, self._radius = _CELL_MARGIN * resolution, footprint.radius
        self.clearance_min = footprint.radius + self._margin
        count = int(np.ceil(footprint.radius / resolution))
        steps = resolution * np.arange(-count, count + 1)
        grid = np.stack(np.meshgrid(steps, steps), axis=-1).reshape(-1, 2)
        # The corners, and points of the interior. Routes keep the inscribed circle free.
        inside = grid[footprint.distances(grid) <= 0.0]
        ends = np.roll(footprint.corners, -1, axis=0)
        shares = np.linspace(0.0, 1.0, 2 * count + 1, endpoint=False)[:, None, None]
        outline = (footprint.corners + shares * (ends - footprint.corners)).reshape(-1, 2)
        points = np.concatenate([outline, inside])
        self._points = points[np.hypot(*points.T) > footprint.inscribed_radius - resolution]

    def collides(self, points_map: NDArray[np.float64], costmap: InflatedCostmap) -> NDArray[np.bool_]:
        """Return at which points of a route [m], shape (n, 2), the footprint touches an obstacle, shape (n,)."""
        collides = np.zeros(len(points_map), dtype=np.bool_)
        near = np.flatnonzero(costmap.clearance_at(points_map) <= self.clearance_min)
        if len(near) == 0 or len(points_map) < 2:
            return collides
        # Direction: the chord over a robot's radius ahead and behind, as lookahead smooths the steps of the grid.
        reach = 1 + int(self._radius / costmap.frame.resolution)
        ahead = points_map[np.minimum(near + reach, len(points_map) - 1)]
        x, y = (ahead - points_map[np.maximum(near - reach, 0)]).T
        yaw = np.arctan2(y, x)
        R = np.stack([np.cos(yaw), -np.sin(yaw), np.sin(yaw), np.cos(yaw)], axis=1).reshape(-1, 2, 2)
        placed = points_map[near, None] + self._points @ R.transpose(0, 2, 1)
        collides[near] = (costmap.clearance_at(placed) <= self._margin).any(axis=1)
        return collides
