"""From frames, poses and a goal to a map, a route and velocities: what the node does, without messages."""

from __future__ import annotations

import math
from collections import Counter
from dataclasses import dataclass, field, replace

import numpy as np
from numpy.typing import NDArray

from reward_planner.core.driving.drivable_area import needed_frame
from reward_planner.core.driving.driving_error import DrivingError
from reward_planner.core.driving.driving_settings import DrivingSettings
from reward_planner.core.driving.pilot import Pilot
from reward_planner.core.driving.route_keeper import RouteKeeper
from reward_planner.core.grid.grid_frame import GridFrame
from reward_planner.core.grid.occupancy_map import UNKNOWN, OccupancyMap
from reward_planner.core.mapping.local_map import LocalMap
from reward_planner.core.mapping.mapping_error import MappingError
from reward_planner.core.mapping.mapping_settings import MappingSettings
from reward_planner.core.mapping.obstacle_mapper import ObstacleMapper
from reward_planner.core.mapping.pose_trail import PoseTrail, PoseVerdict
from reward_planner.core.mapping.waiting_frames import DropReason, WaitingFrames
from reward_planner.core.planner_settings import PlannerSettings
from reward_planner.core.reward.reward_settings import RewardSettings
from reward_planner.core.route.route import NoRouteReason
from reward_planner.core.voxels.count_points import PointTally
from reward_planner.core.voxels.voxel_settings import VoxelSettings
from shirube_geometry import CameraMount, PlanarPose


@dataclass(frozen=True)
class NavigatorSettings:
    """All settings of the method, part by part."""

    voxels: VoxelSettings = field(default_factory=VoxelSettings)
    mapping: MappingSettings = field(default_factory=MappingSettings)
    planner: PlannerSettings = field(default_factory=PlannerSettings)
    reward: RewardSettings = field(default_factory=RewardSettings)
    driving: DrivingSettings = field(default_factory=DrivingSettings)


@dataclass(frozen=True)
class SensorFrame:
    """Points that a sensor saw at once.

    Attributes:
        points: shape (n, 3), in the sensor's optical frame [m].
        focal_length: density of the points, see `SensorView`.
    """

    points: NDArray[np.float32]
    focal_length: float


@dataclass(frozen=True)
class MappedFrame:
    """A frame that is in the map.

    Attributes:
        stamp: of the frame [s].
        local: the map around the robot.
        tally: what became of the points.
    """

    stamp: float
    local: LocalMap
    tally: PointTally


class Navigator:
    """Maps, plans and drives.

    Attributes:
        mapper: of what the sensor sees.
        pilot: who drives.
        frames: that wait for their poses.
        verdicts: number of poses by what became of them.
    """

    def __init__(self, mount: CameraMount, settings: NavigatorSettings) -> None:
        """Begin with nothing known.

        Args:
            mount: pose of the sensor's optical frame in the base frame.
            settings: of all parts.

        Raises:
            VoxelError: settings that leave no voxels.
        """
        self._settings = settings
        self.mapper = ObstacleMapper(mount, settings.voxels, settings.mapping)
        self.pilot = Pilot(self.mapper.map, settings.planner, settings.reward, settings.driving)
        self.frames: WaitingFrames[SensorFrame] = WaitingFrames(settings.mapping.pose_wait)
        self.verdicts: Counter[PoseVerdict] = Counter()
        self._trail = PoseTrail(settings.mapping)
        self._known_frame: GridFrame | None = None

    def use_map(self, known: OccupancyMap) -> None:
        """Go on with a map that was made before; from now on goals must be on it, or where something was seen since.

        Raises:
            MappingError: its cells have another size, or there is no room for it and the strip around it.
        """
        observed = known.occupancy != UNKNOWN
        self.mapper.map.write(LocalMap(known.frame, known.occupancy, observed))
        self._refuse_too_large(known.frame)
        self._known_frame = known.frame

    def _refuse_too_large(self, frame: GridFrame) -> None:
        """Refuse a known map that was cut off, or on which no route could be sought."""
        settings, kept = self._settings, self.mapper.map
        keep_away = settings.planner.robot_radius + settings.driving.clearance_margin
        area = needed_frame(kept, frame.centre_of([(0, 0)]), keep_away)
        if kept.refused or area.columns * area.rows > kept.cells_max:
            raise MappingError(
                f'the known map has {frame.columns} x {frame.rows} cells, with the room around it more than cells_max '
                f'{kept.cells_max}; raise cells_max, cut the map or take a larger resolution'
            )

    def set_goal(self, T_map_goal: PlanarPose) -> None:
        """Take a goal; the one before is forgotten, also if this one is refused.

        Raises:
            DrivingError: a number that is not finite, or a goal outside of the known map.
        """
        self.pilot.forget_goal()
        self.pilot.set_goal(T_map_goal)
        frame = self._known_frame
        if frame is not None and self._is_outside(frame, T_map_goal):
            self.pilot.forget_goal()
            end_x = frame.origin_x + frame.columns * frame.resolution
            end_y = frame.origin_y + frame.rows * frame.resolution
            raise DrivingError(
                f'the goal at x {T_map_goal.x:.2f} m, y {T_map_goal.y:.2f} m is outside of the map, which reaches from '
                f'x {frame.origin_x:.2f} to {end_x:.2f} m and y {frame.origin_y:.2f} to {end_y:.2f} m; give one on it'
            )

    def _is_outside(self, frame: GridFrame, place: PlanarPose) -> bool:
        """Return whether a place is neither on the known map nor where something was seen since."""
        point = (place.x, place.y)
        if bool(frame.contains(frame.cell_of(point))):
            return False
        resolution = self.mapper.map.resolution
        x, y = (resolution * math.floor(number / resolution) for number in point)
        cell = self.mapper.map.occupancy_in(GridFrame(x, y, resolution, 1, 1))
        return bool(cell[0, 0] == UNKNOWN)

    def add_pose(self, stamp: float, T_map_base: PlanarPose) -> PoseVerdict:
        """Take the robot's pose at a time [s], and say what became of it; while poses jump the robot stands."""
        verdict = self._trail.add(stamp, T_map_base)
        self.verdicts[verdict] += 1
        if verdict in (PoseVerdict.TAKEN, PoseVerdict.RELOCATED):
            self.pilot.robot_at(stamp, T_map_base)
        elif self._trail.has_jumped:
            self.pilot.robot_at(stamp, None)
        return verdict

    def add_frame(self, stamp: float, now: float, frame: SensorFrame) -> None:
        """Take a frame, with its stamp and the time at which it came [s]; `work` maps it when its pose is there."""
        self.frames.put(stamp, now, frame)

    def work(self, now: float) -> list[MappedFrame]:
        """Map the frames whose poses are known by now [s]; a blind one, see `PointTally.is_blind`, is none.

        Raises:
            MappingError: a frame is blind, and no other came with it.
        """
        mapped, is_blind = [], False
        for stamp, frame, T_map_base in self.frames.take(now, self._trail):
            local, tally = self.mapper.add(stamp, frame.points, T_map_base, frame.focal_length)
            if tally.is_blind:
                is_blind = True
                continue
            self.pilot.map_changed(stamp, local.frame)
            mapped.append(MappedFrame(stamp, local, tally))
        if is_blind and not mapped:
            raise MappingError(
                'a frame has no finite point, or nearly all are nearer than range_min; check that nothing covers the '
                'camera, the robot stands meanwhile'
            )
        return mapped

    def route_between(
        self, start: PlanarPose | None, goal: PlanarPose, now: float
    ) -> NDArray[np.float64] | NoRouteReason:
        """Return the shortest route on the map as it is known, whatever the mode, or why there is none.

        Args:
            start: where it begins; None where the robot is.
            goal: where it ends.
            now: the time [s].

        Returns:
            shape (n, 2) [m].

        Raises:
            DrivingError: the robot's pose is asked for and not known, or the goal is too far away.
        """
        begin = start or self.pilot.fresh_robot(now)
        if begin is None:
            raise DrivingError("the robot's pose is not known or too old; give a start")
        frame = self._known_frame
        if frame is not None:
            for place, reason in ((goal, NoRouteReason.GOAL_OUTSIDE), (begin, NoRouteReason.START_OUTSIDE)):
                if self._is_outside(frame, place):
                    return reason
        planner = replace(self._settings.planner, mode='optimal')
        settings = self._settings
        keeper = RouteKeeper(self.mapper.map, (goal.x, goal.y), planner, settings.reward, settings.driving)
        keeper.update(0.0, begin)
        return keeper.points_map if keeper.problem is None else keeper.problem

    def clear_map(self) -> None:
        """Forget the map, the known one too; the goal stays."""
        self.mapper.clear()
        self._known_frame = None
        self.pilot.map_cleared()

    def time_jumped(self) -> None:
        """Forget poses, frames and the goal; to be called by whoever watches the stamps; the map stays."""
        self._trail = PoseTrail(self._settings.mapping)
        dropped = self.frames.dropped
        dropped[DropReason.TIME_BACK] += len(self.frames)
        self.frames = WaitingFrames(self._settings.mapping.pose_wait)
        self.frames.dropped = dropped
        self.pilot.time_jumped()
