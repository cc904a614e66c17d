"""Mapping, planning and control of one robot: the node's logic without ROS messages."""

import math
from collections import Counter
from collections.abc import Sequence
from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray

from reward_planner.core.driving.drive_controller import DriveController
from reward_planner.core.driving.inflated_costmap import required_frame
from reward_planner.core.driving.moving_obstacle_policy import MovingObstacle
from reward_planner.core.driving.replanner import Replanner
from reward_planner.core.mapping.global_map import LocalMap
from reward_planner.core.mapping.obstacle_mapper import ObstacleMapper
from reward_planner.core.mapping.pose_buffer import DropReason, PoseBuffer, PoseMessageFilter, PoseStatus
from reward_planner.core.occupancy_map import UNKNOWN, GridFrame, OccupancyMap
from reward_planner.core.reward_planner_error import DrivingError, RewardPlannerError
from reward_planner.core.route.route import NoRoute
from reward_planner.core.settings import (
    DrivingSettings,
    MappingSettings,
    PlannerSettings,
    RewardSettings,
    VoxelSettings,
)
from reward_planner.core.voxels.frame_kernels import PointCounts
from shirube_core.geometry import SE2, CameraMount

_NEAR_FRACTION = 0.25  # of too near points in a frame after which an obstacle, not a cover, may fill the view


@dataclass(frozen=True)
class NavigatorSettings:
    """Settings of mapping, planning and control."""

    voxels: VoxelSettings = field(default_factory=VoxelSettings)
    mapping: MappingSettings = field(default_factory=MappingSettings)
    planner: PlannerSettings = field(default_factory=PlannerSettings)
    reward: RewardSettings = field(default_factory=RewardSettings)
    driving: DrivingSettings = field(default_factory=DrivingSettings)


@dataclass(frozen=True)
class SensorFrame:
    """Points of one sensor frame.

    Attributes:
        points: points in the sensor's optical frame [m], shape (n, 3).
        focal_length: density of the points, see `SensorView`.
        mount: pose of the optical frame in the base frame; None for the navigator's.
    """

    points: NDArray[np.float32]
    focal_length: float
    mount: CameraMount | None = None


@dataclass(frozen=True)
class MappedFrame:
    """A frame that was added to the map.

    Attributes:
        stamp: stamp of the frame [s].
        local: local map around the robot.
        point_counts: number of points by outcome.
    """

    stamp: float
    local: LocalMap
    point_counts: PointCounts


class Navigator:
    """Maps obstacles, plans routes and controls the robot.

    Attributes:
        mapper: obstacle map.
        controller: drive controller.
        message_filter: frames that wait for the pose at their stamp.
        pose_status_counts: number of poses by status.
        moving_obstacles: obstacles that move; they are not in the map.
    """

    def __init__(self, mount: CameraMount, settings: NavigatorSettings) -> None:
        """Start with an empty map; ``mount`` is the pose of the sensor's optical frame in the base frame."""
        self._settings = settings
        self.mapper = ObstacleMapper(mount, settings.voxels, settings.mapping)
        planning = (settings.planner, settings.reward, settings.driving)
        self.controller = DriveController(self.mapper.map, *planning, clear_around=self.clear_around)
        self.message_filter: PoseMessageFilter[SensorFrame] = PoseMessageFilter(settings.mapping.pose_wait)
        self.pose_status_counts: Counter[PoseStatus] = Counter()
        self._pose_buffer = PoseBuffer(settings.mapping)
        self._static_map_frame: GridFrame | None = None
        self._near_fraction = 0.0  # of the latest mapped frame
        self._static_cells = self.mapper.map.snapshot()

    @property
    def moving_obstacles(self) -> list[MovingObstacle]:
        """Moving obstacles of the latest frame, in the map frame."""
        return self.mapper.moving.obstacles

    def apply_settings(self, mount: CameraMount, settings: NavigatorSettings) -> None:
        """Use another mount and other settings, but those of poses, map and voxel sizes; the maps are kept.

        Raises:
            RewardPlannerError: contradictory settings; the former ones stay.
        """
        self.mapper.apply_settings(mount, settings.voxels)
        self.controller.apply_settings(settings.planner, settings.reward, settings.driving)
        self._settings = settings

    def set_static_map(self, static_map: OccupancyMap) -> None:
        """Load a static map; goals must be on it or on cells observed since.

        Raises:
            RewardPlannerError: its resolution differs, or it is too large with its margin.
        """
        frame, global_map, settings = static_map.frame, self.mapper.map, self._settings
        global_map.write(LocalMap(frame, static_map.occupancy, static_map.occupancy != UNKNOWN))
        # Its cells and a costmap around it must fit into cells_max.
        inflation_radius = settings.planner.robot_radius + settings.driving.clearance_margin
        costmap = required_frame(global_map, frame.centre_of([(0, 0)]), inflation_radius)
        if global_map.rejected_cells or costmap.size > global_map.cells_max:
            raise RewardPlannerError(
                f'map_file has {frame.columns} x {frame.rows} cells, with its margin more than cells_max '
                f'{global_map.cells_max}; raise cells_max, crop the map or use a larger resolution'
            )
        self._static_map_frame, self._static_cells = frame, global_map.snapshot()

    def set_goal(self, T_map_goal: SE2, path: Sequence[SE2] | None = None) -> None:
        """Set a goal, with a path to follow or without; a goal that is rejected does not cancel the previous one.

        Raises:
            DrivingError: the goal is not finite or outside of the static map.
        """
        frame, is_finite = self._static_map_frame, math.isfinite(T_map_goal.x + T_map_goal.y)
        if frame is not None and is_finite and self._is_outside(frame, T_map_goal):
            (low_x, low_y), (high_x, high_y) = frame.corners
            raise DrivingError(
                f'the goal at x {T_map_goal.x:.2f} m, y {T_map_goal.y:.2f} m is outside of the map, which extends from '
                f'x {low_x:.2f} to {high_x:.2f} m and y {low_y:.2f} to {high_y:.2f} m; give one on it'
            )
        points = None if path is None else np.array([(each.x, each.y) for each in path])
        self.controller.set_goal(T_map_goal, points)

    def _is_outside(self, frame: GridFrame, place: SE2) -> bool:
        """Return whether a pose is neither on the static map nor on a cell observed since."""
        point = (place.x, place.y)
        if bool(frame.contains(frame.cell_of(point))):
            return False
        resolution = self.mapper.map.resolution
        x, y = (resolution * math.floor(number / resolution) for number in point)
        cell = self.mapper.map.occupancy_in(GridFrame(x, y, resolution, 1, 1))
        return bool(cell[0, 0] == UNKNOWN)

    def add_pose(self, stamp: float, T_map_base: SE2) -> PoseStatus:
        """Add the robot's pose at a stamp [s] and return its status; the robot stops while poses jump."""
        status = self._pose_buffer.add(stamp, T_map_base)
        self.pose_status_counts[status] += 1
        if status is PoseStatus.RELOCATED:
            self.mapper.moving.reset()
        if status in (PoseStatus.ACCEPTED, PoseStatus.RELOCATED):
            self.controller.update_pose(stamp, T_map_base)
        elif self._pose_buffer.has_jumped:
            self.controller.update_pose(stamp, None)
        return status

    def add_frame(self, stamp: float, now: float, frame: SensorFrame) -> None:
        """Queue a frame with its stamp and time of receipt [s] for `process_frames`."""
        self.message_filter.add(stamp, now, frame)

    def process_frames(self, now: float) -> list[MappedFrame]:
        """Map the queued frames whose pose is known at a time [s]; occluded frames are skipped.

        Raises:
            RewardPlannerError: all frames are occluded.
        """
        mapped, is_occluded = list[MappedFrame](), False
        self.controller.moving_obstacles = self.moving_obstacles
        for stamp, frame, T_map_base in self.message_filter.take_ready(now, self._pose_buffer):
            local, point_counts = self.mapper.add(stamp, frame.points, T_map_base, frame.focal_length, frame.mount)
            if point_counts.is_occluded:
                is_occluded = True
                if point_counts.near_fraction > 0.0 and self._near_fraction >= _NEAR_FRACTION:
                    self.controller.update_map(stamp, None)
                continue
            self._near_fraction = point_counts.near_fraction
            self.controller.update_map(stamp, local.frame)
            self.controller.moving_obstacles = self.moving_obstacles
            mapped.append(MappedFrame(stamp, local, point_counts))
        if is_occluded and not mapped:
            raise RewardPlannerError(
                'a frame has no finite point, or nearly all are nearer than range_min; the robot stops; check that '
                'nothing covers the camera'
            )
        return mapped

    def route_between(self, start: SE2 | None, goal: SE2, now: float) -> NDArray[np.float64] | NoRoute:
        """Plan a route in the planner's mode on the current map at a time [s]; a start of None is the robot's pose.

        Returns:
            points of the route [m], shape (n, 2), or why there is none.

        Raises:
            DrivingError: the robot's pose is needed and not known, or the goal is too far away.
        """
        start_pose = start or self.controller.fresh_pose(now)
        if start_pose is None:
            raise DrivingError("the robot's pose is unknown or too old; give a start")
        frame = self._static_map_frame
        if frame is not None:
            for place, reason in ((goal, NoRoute.GOAL_OUTSIDE), (start_pose, NoRoute.START_OUTSIDE)):
                if self._is_outside(frame, place):
                    return reason
        settings = self._settings
        replanner = Replanner(
            self.mapper.map.snapshot(),
            (goal.x, goal.y),
            settings.planner,
            settings.reward,
            settings.driving,
            whole_route=True,
        )
        replanner.update(0.0, start_pose)
        return replanner.no_route_reason or replanner.points_map

    def clear_map(self) -> None:
        """Clear the map, including the static map; the goal stays."""
        self.mapper.clear()
        self._static_map_frame, self._static_cells = None, self.mapper.map.snapshot()
        self.controller.reset_map()

    def clear_around(self, place: SE2, radius: float) -> None:
        """Clear the map within a radius [m] of a place, but for the static map; frames map anew what is there."""
        global_map, resolution = self.mapper.map, self.mapper.map.resolution
        half = math.ceil(radius / resolution) + 1
        column, row = (math.floor(number / resolution) - half for number in (place.x, place.y))
        frame = GridFrame(column * resolution, row * resolution, resolution, 2 * half + 1, 2 * half + 1)
        centres = frame.centre_of(np.moveaxis(np.indices(frame.shape), 0, -1))
        is_near = np.hypot(*np.moveaxis(centres - (place.x, place.y), -1, 0)) <= radius
        cleared = is_near & (global_map.occupancy_in(frame) != UNKNOWN)
        global_map.write(LocalMap(frame, self._static_cells.occupancy_in(frame), cleared))
        self.mapper.voxels.clear()
        self.controller.update_cells(frame)

    def handle_time_jump(self) -> None:
        """Reset poses, queued frames and goal after a jump of the clock; the map stays."""
        self._pose_buffer = PoseBuffer(self._settings.mapping)
        self.mapper.moving.reset()
        dropped = self.message_filter.dropped
        dropped[DropReason.TIME_JUMP] += len(self.message_filter)
        self.message_filter = PoseMessageFilter(self._settings.mapping.pose_wait)
        self.message_filter.dropped = dropped
        self.controller.handle_time_jump()
