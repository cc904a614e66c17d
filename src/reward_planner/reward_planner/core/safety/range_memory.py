"""Obstacles that one range sensor saw, in the frame of the odometry, and whether they move."""

import math
from collections import deque
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from reward_planner.core.safety.cell_classes import PERSON_TIME, classify
from reward_planner.core.safety.range_frame import RangeFrame
from reward_planner.core.safety.range_kernels import (
    CELL,
    FREE,
    NEVER,
    STATIC,
    UNSURE,
    Cells,
    bin_rays,
    carve,
    clear,
    insert,
    passed,
)
from reward_planner.core.safety.safety_settings import SourceSettings
from shirube_core.geometry import SE2, rotation_matrix

_MOVER_KEPT = 0.5  # a moving obstacle that left the field of view is kept for this long [s]
# The way after which odometry has drifted by as much as the robot keeps clear, and steps in which it is measured [m].
_DRIVEN_MAX, _TRAIL_STEP = 2.0, 0.05


class ObstacleCells(NamedTuple):
    """Obstacles: positions in the frame of the odometry, shape (n, 2) [m], stamps of the last hit [s], and class."""

    xy: NDArray[np.float64]
    stamp: NDArray[np.float64]
    kind: NDArray[np.int8]


class RangeMemory:
    """Compares each measurement with the last seconds: what occupies space that was seen free has moved.

    A static obstacle stays until rays pass at its height, so that one too low or too near to be seen is not forgotten.

    Attributes:
        origin: position of the sensor in the frame of the odometry, shape (3,) [m].
    """

    def __init__(self, settings: SourceSettings, memory: float) -> None:
        """Start empty; obstacles out of view are kept for ``memory`` [s]."""
        self._settings, self._memory = settings, memory
        self._trail: deque[tuple[float, float, SE2]] = deque()  # stamp [s], way until then [m], pose
        side = 2 * math.ceil(settings.range_max / CELL) + 3
        self._cells = Cells(
            np.full((side, side), np.iinfo(np.int64).min),
            np.full((side, side), NEVER),
            np.full((side, side), NEVER),
            np.full((side, side), NEVER),
            np.full((side, side), NEVER),
            np.full((side, side), NEVER),
            np.zeros((side, side, 3)),
            np.zeros((side, side, 2)),
            np.zeros((side, side), dtype=np.int8),
            np.zeros((side, side), dtype=np.bool_),
        )

    def update(self, stamp: float, frame: RangeFrame, T_odom_base: SE2, used: NDArray[np.bool_]) -> None:
        """Add a measurement of a stamp [s], at a pose of the base.

        Args:
            stamp: stamp [s], later than those before.
            frame: rays in the base frame.
            T_odom_base: pose of the base at the stamp.
            used: which rays end on an obstacle rather than on the robot or out of its heights, shape (n,).
        """
        settings, cells = self._settings, self._cells
        turn = np.eye(3)
        turn[:2, :2] = rotation_matrix(T_odom_base.yaw)
        offset = np.array([T_odom_base.x, T_odom_base.y, 0.0])
        ends, origin = frame.ends @ turn.T + offset, turn @ frame.origin + offset
        heights = settings.height_min, settings.height_max
        noise = settings.range_noise
        bins = bin_rays(origin, ends, frame.is_hit, heights)
        self._bins, self.origin = bins, origin
        carve(cells, bins, origin, stamp, settings.range_max, noise)
        insert(cells, ends, used, stamp, settings.points_min)
        clear(cells, bins, origin, stamp, noise)
        classify(cells, origin, stamp, noise)
        cells.kind[(cells.kind == UNSURE) & (cells.last < stamp)] = STATIC  # it left the view without having moved
        at_rest = np.where(cells.arrived, min(self._memory, PERSON_TIME), self._memory)
        kept = np.where(cells.kind == STATIC, at_rest, _MOVER_KEPT)
        cells.kind[cells.last < np.maximum(stamp - kept, self._placed_since(stamp, T_odom_base))] = FREE
        cells.first[cells.kind == FREE] = cells.last[cells.kind == FREE] = NEVER

    def _placed_since(self, stamp: float, T_odom_base: SE2) -> float:
        """Return since when hits are where odometry has them: the robot has not driven far since then [s]."""
        trail = self._trail
        way = trail[-1][1] + trail[-1][2].distance_to(T_odom_base) if trail else 0.0
        if not trail or way > trail[-1][1] + _TRAIL_STEP:
            trail.append((stamp, way, T_odom_base))
        while len(trail) > 1 and way - trail[1][1] > _DRIVEN_MAX:
            trail.popleft()
        return trail[0][0] if way - trail[0][1] > _DRIVEN_MAX else NEVER

    def arrived(self) -> NDArray[np.bool_]:
        """Return which cells of `obstacles` belong to somebody who came, shape (n,)."""
        return self._cells.arrived[self._cells.kind != FREE]

    def obstacles(self) -> ObstacleCells:
        """Return all obstacle cells."""
        cells = self._cells
        chosen = cells.kind != FREE
        return ObstacleCells(cells.xyz[chosen][:, :2], cells.last[chosen], cells.kind[chosen])

    def is_open(self, xy_odom: NDArray[np.float64]) -> NDArray[np.bool_]:
        """Return where the rays of the latest measurement passed, shape (n,), at positions of shape (n, 2) [m]."""
        return passed(self._bins, self.origin, xy_odom, self._settings.range_noise)

    def forget(self, xy_odom: NDArray[np.float64]) -> None:
        """Forget the cells at positions, shape (n, 2) [m]."""
        side = len(self._cells.key)
        for i, j in (np.floor(xy_odom / CELL).astype(np.int64) % side).tolist():
            self._cells.kind[i, j] = FREE
            self._cells.first[i, j] = self._cells.last[i, j] = NEVER
