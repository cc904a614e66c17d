"""Publishes the route and the lookahead point."""

import math
from collections.abc import Callable

from geometry_msgs.msg import PoseStamped
from nav_msgs.msg import Path
from rclpy.node import Node
from std_msgs.msg import ColorRGBA, Header
from visualization_msgs.msg import Marker, MarkerArray

from reward_planner.core.driving.drive_state import DriveCommand
from reward_planner.core.driving.thin_path import thin_path
from reward_planner.core.navigator import Navigator
from shirube_core.geometry import SE2
from shirube_ros.map_conversion import path_message
from shirube_ros.pose_conversion import pose_message, pose_stamped
from shirube_ros.quality_of_service import map_profile, pose_profile

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
