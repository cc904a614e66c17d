"""Updates the local and the global map from points and the robot's pose (2.2)."""

import math

import numpy as np
from numba import njit
from numpy.typing import ArrayLike, NDArray

from reward_planner.core.mapping.global_map import GlobalMap, LocalMap
from reward_planner.core.mapping.moving_points import MovingPoints
from reward_planner.core.occupancy_map import FREE, OCCUPIED, OCCUPIED_THRESHOLD, UNKNOWN, GridFrame
from reward_planner.core.settings import FREE_FRACTION, MappingSettings, VoxelSettings
from reward_planner.core.voxels.frame_kernels import PointCounts
from reward_planner.core.voxels.frame_voxels import FrameVoxels, as_points
from reward_planner.core.voxels.rolling_voxel_grid import NO_TILE, TILE_SIZE, SensorView
from reward_planner.core.voxels.voxel_map import VoxelMap
from shirube_core.geometry import SE2, CameraMount

_FREE_LAYER_FRACTION = 0.5  # of the layers are traversed in a free cell


class ObstacleMapper:
    """Maps the obstacles that one sensor sees.

    Attributes:
        voxels: voxel map around the robot.
        map: global map.
        moving: moving obstacles, whose points are kept out of the maps with the rule log_odds.
    """

    def __init__(self, mount: CameraMount, voxels: VoxelSettings, mapping: MappingSettings) -> None:
        """Start with empty maps; ``mount`` is the pose of the sensor's optical frame in the base frame."""
        self._T_base_sensor = _sensor_pose(mount)
        self.voxels = VoxelMap(voxels)
        self.map = GlobalMap(voxels.resolution, mapping.cells_max)
        self.moving = MovingPoints(voxels)

    def apply_settings(self, mount: CameraMount, voxels: VoxelSettings) -> None:
        """Use another mount and other thresholds from the next frame on; errors are those of `VoxelMap`."""
        self.voxels.apply_settings(voxels)
        self._T_base_sensor = _sensor_pose(mount)

    def add(
        self, stamp: float, points: ArrayLike, T_map_base: SE2, focal_length: float, mount: CameraMount | None = None
    ) -> tuple[LocalMap, PointCounts]:
        """Add a frame; return the local map and the number of points by outcome.

        Args:
            stamp: stamp of the frame [s].
            points: points in the sensor's optical frame [m], array-like, shape (n, 3).
            T_map_base: pose of the robot at the stamp.
            focal_length: density of the points, see `SensorView`.
            mount: pose of the sensor of this frame, None for the usual one.

        Raises:
            RewardPlannerError: points of a wrong shape, or a pose or stamp that is not finite.
        """
        # The sensor in the map: the robot's pose at the stamp and the mount.
        cos, sin = np.cos(T_map_base.yaw), np.sin(T_map_base.yaw)
        rotation = np.array([[cos, -sin, 0.0], [sin, cos, 0.0], [0.0, 0.0, 1.0]])
        T_map_robot = _rigid_transform(rotation, (T_map_base.x, T_map_base.y, 0.0))
        T_base_sensor = self._T_base_sensor if mount is None else _sensor_pose(mount)
        view = SensorView(T_map_robot @ T_base_sensor, focal_length)
        # What moves is no part of the map.
        cloud = as_points(points)
        if self.voxels.settings.rule == 'log_odds':
            cloud = self.moving.static_points(stamp, cloud, view.T_map_sensor)
        # 2.2.2: voxels from the points.
        frame = self.voxels.add(stamp, cloud, view)
        # 2.2.3, step 1: the voxels of obstacles, projected to the floor, and the movable area between them.
        local = project_voxels(self.voxels, view, self.map, frame)
        # 2.2.3, steps 2 and 3: the global map, where the local one observed it.
        self.map.write(local)
        return local, frame.point_counts

    def clear(self) -> None:
        """Clear both maps."""
        self.voxels.clear()
        self.map.clear()
        self.moving.reset()


def _sensor_pose(mount: CameraMount) -> NDArray[np.float64]:
    return _rigid_transform(mount.rotation, mount.xyz)


def _rigid_transform(rotation: NDArray[np.float64], translation: ArrayLike) -> NDArray[np.float64]:
    T = np.eye(4)
    T[:3, :3], T[:3, 3] = rotation, translation
    return T


def project_voxels(voxels: VoxelMap, view: SensorView, global_map: GlobalMap, frame: FrameVoxels) -> LocalMap:
    """Project the voxels within the window of a view to the floor.

    A cell is occupied if any voxel above it has the value of an obstacle. With the rules of means, the paper's, a cell
    is movable (free) if it is in the detection range of the frame, that is, if its rays passed the lower half of the
    voxels above it, and none of these is an obstacle.

    With log-odds a cell is free if no voxel has a positive value and rays traversed its voxels from the lowest up
    without a gap, at least half of them. So it is not free where rays only pass over a box, or under and over a shelf.
    An obstacle that points showed is cleared once rays traversed all of its hit voxels, even if the rest of the cell
    was not seen. An obstacle of a map file, or of voxels that were dropped, is cleared only when its cell is free.
    """
    settings = voxels.settings
    window, slots = voxels.slots_around(view)
    is_mean = settings.rule != 'log_odds'
    value_min = settings.value_min if is_mean else settings.log_odds_occupied
    free_max = -FREE_FRACTION * settings.log_odds_pass
    limits = float(np.float32(value_min)), float(np.float32(free_max))  # rounded as the values are
    x, y, _ = window.corner
    grid = GridFrame(float(x), float(y), window.resolution, window.side, window.side)
    is_detected = _detected_cells(frame) if is_mean else np.zeros(grid.shape, dtype=np.bool_)
    occupancy, observed = _project(
        voxels.tiles.values,
        voxels.tiles.frames,
        slots,
        limits,
        global_map.occupancy_in(grid) >= OCCUPIED_THRESHOLD,
        voxels.tiles.has_obstacle,
        is_detected,
    )
    return LocalMap(grid, occupancy, observed)


def _detected_cells(frame: FrameVoxels) -> NDArray[np.bool_]:
    """Return the cells whose lower half of voxels rays traversed without a gap, shape (side, side), rows along y."""
    side, layers = frame.window.side, frame.window.layers
    is_traversed = np.zeros(side * side * layers, dtype=np.bool_)
    is_traversed[frame.traversed] = True
    lower = math.ceil(_FREE_LAYER_FRACTION * layers)
    return np.asarray(is_traversed.reshape(side, side, layers)[:, :, :lower].all(axis=2)).T


@njit(cache=True)
def _project(
    values: NDArray[np.float32],
    frames: NDArray[np.float32],
    slots: NDArray[np.int64],
    limits: tuple[float, float],
    was_occupied: NDArray[np.bool_],
    has_obstacle: NDArray[np.bool_],
    is_detected: NDArray[np.bool_],
) -> tuple[NDArray[np.int8], NDArray[np.bool_]]:
    """Return occupancy and observed cells of the window; rows along y.

    Values have the shape (slots, TILE_SIZE, TILE_SIZE, layers); if frames are counted, their numbers have it, too, and
    divide the values. The limits are the lowest value of an obstacle and the highest of free space. ``was_occupied``
    are cells of the global map; ``has_obstacle`` are columns whose obstacle rays may clear, updated in place.
    ``is_detected`` are cells in the detection range of the frame, which are movable unless occupied; with log-odds
    there are none.
    """
    side, is_mean = TILE_SIZE * len(slots), frames.shape[3] > 1
    occupancy = np.full((side, side), UNKNOWN, dtype=np.int8)
    observed = np.zeros((side, side), dtype=np.bool_)
    for i, j in np.ndindex(slots.shape):
        slot = slots[i, j]
        if slot == NO_TILE:
            continue
        for column in range(TILE_SIZE):
            for row in range(TILE_SIZE):
                highest, free_layers, free_from_bottom = np.float32(0.0), 0, 0
                for layer, value in enumerate(values[slot, column, row]):
                    if is_mean:
                        highest = max(highest, value / max(frames[slot, column, row, layer], np.float32(1.0)))
                    else:
                        highest = max(highest, value)
                    free_layers += value <= limits[1]
                    free_from_bottom += free_layers == layer + 1
                cell = (j * TILE_SIZE + row, i * TILE_SIZE + column)
                if highest >= limits[0]:
                    occupancy[cell], observed[cell] = OCCUPIED, True
                    has_obstacle[slot, column, row] |= not was_occupied[cell]
                elif is_detected[cell]:
                    occupancy[cell], observed[cell] = FREE, True
                    has_obstacle[slot, column, row] = False
                elif highest <= 0.0:
                    is_free = free_layers == free_from_bottom >= _FREE_LAYER_FRACTION * values.shape[3]
                    occupancy[cell] = FREE if is_free else UNKNOWN
                    observed[cell] = is_free or has_obstacle[slot, column, row]
                    has_obstacle[slot, column, row] = False
    return occupancy, observed
