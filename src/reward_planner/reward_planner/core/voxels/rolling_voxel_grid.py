"""Rolling voxel grid: the window of one frame, and tiles of voxels in bounded memory, of which the nearest are kept."""

import math
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np
from numba import njit
from numpy.typing import NDArray

from reward_planner.core.reward_planner_error import RewardPlannerError
from reward_planner.core.settings import FREE_FRACTION, VoxelSettings

_INITIAL_TILES = 64
_ARRAYS = ('values', 'frames', 'stamps', 'has_obstacle', 'cleared', 'changed', 'was_free')
NO_TILE = -1
TILE_SIZE = 16
"""Side of a tile [voxels]."""

_VOXELS_MAX = 2**31 - 1  # flat indices of a window have 32 bits
_ORTHONORMAL_WITHIN = 1e-5
_BIN = 0.05  # bin size of the direction histogram [tangent]
_BINS = 64  # bins to each side: up to 72 degrees off the axis


@dataclass(frozen=True)
class SensorView:
    """Pose and point density of a sensor at the time of a frame.

    Attributes:
        T_map_sensor: transform from the sensor's optical frame (z forward) to the map frame, shape (4, 4).
        focal_length: points per unit of the tangent of the viewing angle, focal length of a depth image [px]; 0 for
            unknown density.

    Raises:
        RewardPlannerError: not a rigid transform, or a number that is not finite or negative.
    """

    T_map_sensor: NDArray[np.float64]
    focal_length: float

    def __post_init__(self) -> None:
        T = np.asarray(self.T_map_sensor)
        if T.shape != (4, 4) or not np.isfinite(T).all() or (T[3] != (0.0, 0.0, 0.0, 1.0)).any():
            raise RewardPlannerError('T_map_sensor is not a rigid transform; give a 4 x 4 matrix of finite numbers')
        deviation = np.abs(T[:3, :3] @ T[:3, :3].T - np.eye(3)).max()
        if deviation > _ORTHONORMAL_WITHIN or np.linalg.det(T[:3, :3]) < 0.0:
            raise RewardPlannerError(
                f'the rotation of T_map_sensor deviates by {deviation:.3g}; give an orthonormal, right-handed one'
            )
        if not (math.isfinite(self.focal_length) and self.focal_length >= 0.0):
            raise RewardPlannerError(f'focal_length is {self.focal_length} px, it must be 0 or more')

    @property
    def origin(self) -> NDArray[np.float64]:
        """Position of the sensor in the map frame [m], shape (3,)."""
        return self.T_map_sensor[:3, 3]


class FrameWindow(NamedTuple):
    """A square of whole tiles around the sensor, from the lowest to the highest voxel.

    Cells of the window are flat indices of an array of shape (side, side, layers) along x, y and z.

    Attributes:
        tile_x: index of the first tile along x; tile 0 starts at x = 0 of the map.
        tile_y: index of the first tile along y; tile 0 starts at y = 0 of the map.
        side: number of voxels along x and along y.
        layers: number of voxels along z.
        resolution: side of a voxel [m].
        bottom: height of the lower face of the lowest layer [m].
    """

    tile_x: int
    tile_y: int
    side: int
    layers: int
    resolution: float
    bottom: float

    @property
    def corner(self) -> NDArray[np.float64]:
        """Lowest corner in the map frame [m], shape (3,)."""
        metres = TILE_SIZE * self.resolution
        return np.array([self.tile_x * metres, self.tile_y * metres, self.bottom])

    @property
    def tiles(self) -> int:
        """Number of tiles along x and along y."""
        return self.side // TILE_SIZE


def window_around(view: SensorView, settings: VoxelSettings) -> FrameWindow:
    """Return the window that contains all points within range of a view.

    Raises:
        RewardPlannerError: the view is too far from the map's origin for exact voxels.
    """
    s, reach = settings.resolution, settings.range_max
    first = np.floor((view.origin[:2] - reach) / (TILE_SIZE * s))
    if np.abs(first).max() > 2**31:
        raise RewardPlannerError('the sensor is too far from the origin of the map; check that its pose is in metres')
    side, layers = window_shape(settings)
    return FrameWindow(int(first[0]), int(first[1]), side, layers, s, settings.height_min)


def window_shape(settings: VoxelSettings) -> tuple[int, int]:
    """Return the number of voxels of a window along x and y, and along z."""
    tiles = math.ceil((2.0 * settings.range_max / settings.resolution + 2.0) / TILE_SIZE) + 1
    layers = math.ceil((settings.height_max - settings.height_min) / settings.resolution - 1e-6)
    return TILE_SIZE * tiles, layers


def check_voxel_settings(settings: VoxelSettings) -> None:
    """Check that one frame fits into the voxels, and that voxels can become occupied and free.

    A voxel that is always hit rises to log_odds_max, which must be the value of an obstacle; one that is only traversed
    falls to log_odds_min, which must be the value of free space.

    Raises:
        RewardPlannerError: contradictory settings, fewer tiles than one frame needs, or too many voxels.
    """
    s, free = settings, FREE_FRACTION * settings.log_odds_pass
    for low, high, what, is_wrong in (
        ('height_min', 'height_max', 'must be lower', s.height_min >= s.height_max),
        ('range_min', 'range_max', 'must be less', s.range_min >= s.range_max),
        ('log_odds_occupied', 'log_odds_max', 'may not be more', s.log_odds_occupied > s.log_odds_max),
        ('log_odds_min', 'log_odds_pass', f'must be {-free:g} or less', -s.log_odds_min < free),
    ):
        if is_wrong:
            raise RewardPlannerError(
                f'{low} is {getattr(s, low):g}, it {what}; {high} is {getattr(s, high):g}; change one of them'
            )
    side, layers = window_shape(settings)
    tiles = (side // TILE_SIZE) ** 2
    if settings.tiles_max < tiles:
        raise RewardPlannerError(
            f'tiles_max is {settings.tiles_max}, one frame needs {tiles}; raise tiles_max or resolution'
        )
    if side**2 * layers > _VOXELS_MAX:
        raise RewardPlannerError(
            f'one frame covers {side} x {side} x {layers} voxels, more than {_VOXELS_MAX}; '
            'raise resolution or lower range_max'
        )


def equivalent_focal_length(points: NDArray[np.float32]) -> float:
    """Return the focal length of a depth camera with the same point density, see `SensorView` [px], 0 for none.

    It is the median over the directions with points, so outliers and empty directions have no effect. A sparse lidar
    gets a small value, so that each of its points counts. Points behind the sensor or not finite are ignored.
    """
    counts = np.zeros(4 * _BINS**2, dtype=np.int64)
    _count_directions(points, counts)
    filled = counts[counts > 0]
    return float(np.sqrt(np.median(filled)) / _BIN) if len(filled) else 0.0


@njit(cache=True)
def _count_directions(points: NDArray[np.float32], counts: NDArray[np.int64]) -> None:
    """Count points by direction (tangents), shape (4 _BINS^2,)."""
    for x, y, z in points:
        if not z > 0.0:
            continue
        column, row = np.floor(x / z / _BIN) + _BINS, np.floor(y / z / _BIN) + _BINS
        if 0 <= column < 2 * _BINS and 0 <= row < 2 * _BINS:
            counts[int(row) * 2 * _BINS + int(column)] += 1


@njit(cache=True, inline='always')
def unravel_cell(cell: int, side: int, layers: int) -> tuple[int, int, int]:
    """Return column, row and layer of a flat index, as numpy.unravel_index for shape (side, side, layers).

    Multiplying by reciprocals is several times faster than integer division, and exact below 2^40.
    """
    column = int((cell + 0.5) * (1.0 / (side * layers)))
    remainder = cell - column * side * layers
    row = int((remainder + 0.5) * (1.0 / layers))
    return column, row, remainder - row * layers


class RollingVoxelGrid:
    """Voxel values of tiles in the slots of one growing array.

    Attributes:
        values: voxel values, shape (slots, TILE_SIZE, TILE_SIZE, layers), along x, y and z.
        frames: number of frames that observed the voxel, of the shape of the values; (slots, 1, 1, 1) if not counted.
        stamps: time of the last decay of the tile [s], shape (slots,).
        has_obstacle: columns with an uncleared obstacle of points, shape (slots, TILE_SIZE, TILE_SIZE).
        cleared: number of voxels of obstacles that rays cleared since the last hit of the column, of the same shape.
        changed: time of the last such hit or clearing [s], of the same shape.
        was_free: voxels that were free at any time, of the shape of the values; (slots, 1, 1, 1) if frames are counted.
    """

    def __init__(self, layers: int, tiles_max: int, *, counts_frames: bool = False) -> None:
        """Start without tiles, for voxels in so many layers along z; a window has at most ``tiles_max`` tiles."""
        self._tiles_max = tiles_max
        self._slots: dict[tuple[int, int], int] = {}
        self.values = np.empty((0, TILE_SIZE, TILE_SIZE, layers), dtype=np.float32)
        frames_shape = self.values.shape if counts_frames else (0, 1, 1, 1)
        self.frames = np.empty(frames_shape, dtype=np.float32)
        self.stamps = np.empty(0)
        columns = (0, TILE_SIZE, TILE_SIZE)
        self.has_obstacle = np.empty(columns, dtype=np.bool_)
        self.cleared, self.changed = np.empty(columns, dtype=np.uint8), np.empty(columns)
        self.was_free = np.empty((0, 1, 1, 1) if counts_frames else self.values.shape, dtype=np.bool_)
        self._grow(min(_INITIAL_TILES, tiles_max))

    def __len__(self) -> int:
        """Number of tiles."""
        return len(self._slots)

    @property
    def bytes(self) -> int:
        """Memory of all slots, used and free [bytes]."""
        return sum(int(getattr(self, name).nbytes) for name in _ARRAYS)

    def slots_of(self, window: FrameWindow) -> NDArray[np.int64]:
        """Return the slots of a window's tiles, shape (tiles, tiles) along x and y, NO_TILE for missing ones."""
        places = ((window.tile_x + i, window.tile_y + j) for i, j in np.ndindex(window.tiles, window.tiles))
        slots = [self._slots.get(place, NO_TILE) for place in places]
        return np.array(slots, dtype=np.int64).reshape(window.tiles, window.tiles)

    def allocate_missing(
        self, window: FrameWindow, slots: NDArray[np.int64], needed: NDArray[np.bool_], stamp: float
    ) -> None:
        """Allocate needed tiles of the window that are missing; the farthest tiles are evicted if there are too many.

        ``slots`` and ``needed`` have the shape (tiles, tiles); slots are updated in place.
        """
        missing = np.argwhere(needed & (slots == NO_TILE))
        if len(missing) == 0:
            return
        self._evict_farthest(window, len(missing))
        free = np.setdiff1d(np.arange(len(self.values)), np.fromiter(self._slots.values(), dtype=np.int64))
        for (i, j), slot in zip(missing.tolist(), free.tolist(), strict=False):
            place = (window.tile_x + i, window.tile_y + j)
            self._slots[place] = slots[i, j] = slot
            for name in _ARRAYS:
                getattr(self, name)[slot] = 0
            self.stamps[slot] = stamp

    def clear(self) -> None:
        """Drop all tiles; the memory stays allocated."""
        self._slots.clear()

    def _evict_farthest(self, window: FrameWindow, count: int) -> None:
        """Provide ``count`` free slots: grow up to tiles_max, then evict the farthest tiles."""
        needed_slots = len(self._slots) + count
        if needed_slots > len(self.values):
            self._grow(min(max(needed_slots, 2 * len(self.values)), self._tiles_max))
        excess = needed_slots - len(self.values)
        if excess <= 0:
            return
        kept = np.array(list(self._slots))
        middle = np.array([window.tile_x, window.tile_y]) + 0.5 * (window.tiles - 1)
        farthest = np.argsort(np.abs(kept - middle).max(axis=1))[::-1][:excess]
        for place in kept[farthest].tolist():
            del self._slots[place[0], place[1]]

    def _grow(self, slots: int) -> None:
        extra = slots - len(self.values)
        for name in _ARRAYS:
            array = getattr(self, name)
            setattr(self, name, np.concatenate([array, np.zeros((extra, *array.shape[1:]), array.dtype)]))
