"""What the planner publishes: the route, the stop and the diagnostics."""

import math
from collections import Counter
from collections.abc import Callable
from typing import Any

from geometry_msgs.msg import PoseStamped
from nav_msgs.msg import Path
from rclpy.node import Node
from std_msgs.msg import ColorRGBA, Header
from visualization_msgs.msg import Marker, MarkerArray

from reward_planner.core.driving.drive_state import DriveCommand, DriveState
from reward_planner.core.mapping.pose_buffer import PoseStatus
from reward_planner.core.navigator import MappedFrame, Navigator
from reward_planner.core.route.route import thin_path
from shirube_core.geometry import SE2
from shirube_ros.diagnostics import Level, Status
from shirube_ros.message_conversion import path_message, pose_message, pose_stamped
from shirube_ros.quality_of_service import map_profile, pose_profile
from shirube_ros.stamps import StampSynchronizer


class PlannerReport:
    """Collects the state of the controller and counters.

    Attributes:
        frame_period_max: time without a mapped frame after which the map is stale [s].
    """

    def __init__(
        self,
        navigator: Navigator,
        now: Callable[[], float],
        frame_period_max: float,
        groups: StampSynchronizer[Any] | None = None,
    ) -> None:
        """Start without counts.

        Args:
            navigator: source of map, pose and route counters.
            now: current time [s], 0 before simulated time starts.
            frame_period_max: initial value of the attribute [s].
            groups: synchronizer of the images, if there are several cameras.
        """
        self._navigator, self._now, self.frame_period_max = navigator, now, frame_period_max
        self._groups = groups
        self._last_frame_time: float | None = None
        self._groups_at_last_frame = 0
        self._drive: DriveCommand | None = None
        self._frames = 0
        self._points: Counter[str] = Counter()

    def add_frame(self, frame: MappedFrame) -> None:
        """Count a mapped frame."""
        self._frames += 1
        self._last_frame_time = self._now()
        self._groups_at_last_frame = 0 if self._groups is None else self._groups.completed
        self._points.update(frame.point_counts._asdict())

    def add_drive(self, drive: DriveCommand) -> None:
        """Set the latest output of the drive controller."""
        self._drive = drive

    def status(self) -> Status:
        """Return the diagnostic status."""
        navigator = self._navigator
        values = {'frames in the map': str(self._frames)}
        values |= {f'frames dropped: {why.value}': str(n) for why, n in navigator.message_filter.dropped.items()}
        if self._groups is not None:
            values['images dropped: no others with the same stamp'] = str(self._groups.dropped)
        values |= {f'points {kind.replace("_", " ")}': str(n) for kind, n in self._points.items() if n}
        values |= {
            f'poses: {status.value}': str(n)
            for status, n in navigator.pose_status_counts.items()
            if status is not PoseStatus.ACCEPTED
        }
        values['map [MB]'] = f'{navigator.mapper.map.bytes / 1e6:.2f}'
        if navigator.mapper.map.rejected_cells:
            values['cells rejected, the map is full'] = str(navigator.mapper.map.rejected_cells)
        replanner = navigator.controller.replanner
        if replanner is not None:
            values['routes taken'] = str(replanner.replan_count)
        if navigator.controller.recovery.tried:
            values['recovery'] = navigator.controller.recovery.summary
        if navigator.moving_obstacles:
            values['moving obstacles'] = str(len(navigator.moving_obstacles))
        is_ok = self._drive is None or not self._drive.state.needs_attention
        activity = DriveState.IDLE.value if self._drive is None else self._drive.detail
        stale = self._stale_input()
        level = Level.OK if is_ok and stale is None else Level.WARN
        return Status(level, activity if stale is None else f'{activity}; {stale}', values)

    def _stale_input(self) -> str | None:
        """Return why no frame was mapped for too long, None if one was."""
        now = self._now()
        if now <= 0.0:
            return None
        if self._last_frame_time is None or now < self._last_frame_time:
            self._last_frame_time = now
        age = now - self._last_frame_time
        if age <= self.frame_period_max:
            return None
        line = f'no frame mapped for {age:.1f} s'
        if self._groups is None or self._groups.completed > self._groups_at_last_frame:
            return line
        if self._groups.missing_topics:
            return f'{line}: no images of {" and ".join(self._groups.missing_topics)}; check the topics'
        return f'{line}: the stamps of the images differ; synchronize the cameras'


_OBSTACLE = ColorRGBA(r=1.0, g=0.5, b=0.7, a=0.6)


class RoutePublisher:
    """Publishes ``~/plan``, transient local, ``~/next_waypoint`` and ``~/moving_obstacles``."""

    def __init__(self, node: Node, navigator: Navigator, header: Callable[[], Header]) -> None:
        """Create the publishers; ``header`` returns that of a message of now in the map."""
        self._navigator, self._header = navigator, header
        self._plan = node.create_publisher(Path, '~/plan', map_profile())
        self._waypoint = node.create_publisher(PoseStamped, '~/next_waypoint', pose_profile())
        self._obstacles = node.create_publisher(MarkerArray, '~/moving_obstacles', pose_profile())
        self._had_obstacles = False
        self._number: tuple[int, int] | None = None

    def publish(self, drive: DriveCommand) -> None:
        """Publish the lookahead point of a control cycle, if there is one, and the route if it changed."""
        controller = self._navigator.controller
        points, replanner, goal = controller.points_map, controller.replanner, controller.goal
        number = None
        if replanner is not None and len(points):
            number = controller.goal_count, replanner.replan_count
        if number != self._number:
            self._number = number
            points = thin_path(points, 0.5 * self._navigator.mapper.map.resolution)
            self._plan.publish(path_message(points, 0.0 if goal is None else goal.yaw, self._header()))
        if drive.waypoint_map is not None:
            self._waypoint.publish(pose_stamped(SE2(*drive.waypoint_map, 0.0), self._header()))
        if self._navigator.moving_obstacles or self._had_obstacles:
            self._obstacles.publish(MarkerArray(markers=self._obstacle_markers()))
        self._had_obstacles = bool(self._navigator.moving_obstacles)

    def _obstacle_markers(self) -> list[Marker]:
        """Return a disc for each moving obstacle and an arrow along its way in one second; deletes the previous."""
        header, height = self._header(), 0.05
        markers = [Marker(header=header, action=Marker.DELETEALL)]
        for number, each in enumerate(self._navigator.moving_obstacles):
            speed, yaw = math.hypot(*each.velocity), math.atan2(each.velocity[1], each.velocity[0])
            for kind, width in ((Marker.CYLINDER, 2.0 * each.radius), (Marker.ARROW, speed)):
                marker = Marker(header=header, ns=str(kind), id=number, type=kind, color=_OBSTACLE)
                marker.pose = pose_message(SE2(*each.position, yaw))
                marker.scale.x, marker.scale.z = width, height
                marker.scale.y = width if kind == Marker.CYLINDER else height
                markers.append(marker)
        return markers
