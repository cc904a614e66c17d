"""Action server for Nav2's ComputePathToPose, if nav2_msgs is installed."""

from __future__ import annotations

from collections.abc import Callable
from importlib import import_module
from importlib.util import find_spec
from typing import Any

import numpy as np
from nav_msgs.msg import Path
from numpy.typing import NDArray
from rclpy.action import ActionServer
from rclpy.node import Node
from std_msgs.msg import Header

from reward_planner.core.reward_planner_error import RewardPlannerError
from reward_planner.core.route.route import NoRoute
from shirube_core.geometry import SE2
from shirube_ros.errors import MessageError
from shirube_ros.map_conversion import path_message
from shirube_ros.pose_conversion import planar_pose

PlanRoute = Callable[[SE2 | None, SE2, float], NDArray[np.float64] | NoRoute]
"""Plans from a start (None for the robot's pose at a time [s]) to a goal: points [m], shape (n, 2), or a reason."""

_NAME = 'compute_path_to_pose'
_CODES = {
    NoRoute.START_OUTSIDE: 'START_OUTSIDE_MAP',
    NoRoute.GOAL_OUTSIDE: 'GOAL_OUTSIDE_MAP',
    NoRoute.START_BLOCKED: 'START_OCCUPIED',
    NoRoute.GOAL_BLOCKED: 'GOAL_OCCUPIED',
    NoRoute.UNREACHABLE: 'NO_VALID_PATH',
    NoRoute.GAVE_UP: 'NO_VALID_PATH',
}


def create_compute_path_server(node: Node, map_frame: str, plan: PlanRoute) -> ActionServer | None:
    """Create the action server of a node; return None if nav2_msgs is not installed."""
    if find_spec('nav2_msgs') is None:
        return None
    action = import_module('nav2_msgs.action').ComputePathToPose

    def execute(handle: Any) -> Any:
        header = Header(stamp=node.get_clock().now().to_msg(), frame_id=map_frame)
        result, problem = handle_request(handle.request, action.Result(), header, plan)
        if problem:
            node.get_logger().warning(f'{_NAME}: {problem}')
            handle.abort()
        else:
            handle.succeed()
        return result

    return ActionServer(node, action, _NAME, execute)


def handle_request(request: Any, result: Any, header: Header, plan: PlanRoute) -> tuple[Any, str]:
    """Fill the result of the action; return it with a one-line error, empty on success.

    The header has the stamp of the result and the frame that goal and start must be in.
    """
    try:
        start = _in_map(request.start, header, 'start') if request.use_start else None
        goal = _in_map(request.goal, header, 'goal')
        route = plan(start, goal, header.stamp.sec + 1e-9 * header.stamp.nanosec)
    except (MessageError, RewardPlannerError) as fault:
        _set_code(result, 'UNKNOWN')
        return result, str(fault)
    result.path = Path(header=header)
    if isinstance(route, NoRoute):
        _set_code(result, _CODES[route])
        return result, route.value
    result.path = path_message(route, goal.yaw, header)
    return result, ''


def _in_map(message: Any, header: Header, name: str) -> SE2:
    if message.header.frame_id not in ('', header.frame_id):
        raise MessageError(
            f'{name} is in the frame {message.header.frame_id!r}; give it in {header.frame_id!r}'
        )
    return planar_pose(message.pose, name)


def _set_code(result: Any, name: str) -> None:
    """Set the error code, which older versions of the action do not have."""
    if hasattr(result, 'error_code'):
        result.error_code = getattr(result, name)
