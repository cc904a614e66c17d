"""Nav2's ComputePathToPose, offered where nav2_msgs is installed: Nav2 asks, this planner answers."""

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
from reward_planner.core.route.route import NoRouteReason
from shirube_geometry import PlanarPose
from shirube_ros.message_error import MessageError
from shirube_ros.occupancy_conversion import path_message
from shirube_ros.pose_conversion import planar_pose

PlanRoute = Callable[[PlanarPose | None, PlanarPose, float], NDArray[np.float64] | NoRouteReason]
"""Plans from a start, None for where the robot is at a time, to a goal: points of shape (n, 2) [m], or why not."""

_NAME = 'compute_path_to_pose'
_CODES = {
    NoRouteReason.START_OUTSIDE: 'START_OUTSIDE_MAP',
    NoRouteReason.GOAL_OUTSIDE: 'GOAL_OUTSIDE_MAP',
    NoRouteReason.START_BLOCKED: 'START_OCCUPIED',
    NoRouteReason.GOAL_BLOCKED: 'GOAL_OCCUPIED',
    NoRouteReason.UNREACHABLE: 'NO_VALID_PATH',
    NoRouteReason.GAVE_UP: 'NO_VALID_PATH',
}


def offer_compute_path(node: Node, map_frame: str, plan: PlanRoute) -> ActionServer | None:
    """Offer the action on a node; return its server, None where nav2_msgs is not installed."""
    if find_spec('nav2_msgs') is None:
        return None
    action = import_module('nav2_msgs.action').ComputePathToPose

    def execute(handle: Any) -> Any:
        header = Header(stamp=node.get_clock().now().to_msg(), frame_id=map_frame)
        result, problem = answer_request(handle.request, action.Result(), header, plan)
        if problem:
            node.get_logger().warning(f'{_NAME}: {problem}')
            handle.abort()
        else:
            handle.succeed()
        return result

    return ActionServer(node, action, _NAME, execute)


def answer_request(request: Any, result: Any, header: Header, plan: PlanRoute) -> tuple[Any, str]:
    """Fill the result of the action, and return it with one line about what is wrong, empty where nothing is.

    Args:
        request: goal of the action: start, goal, use_start.
        result: of the action, to be filled.
        header: stamp, and the frame in which goal and start must be.
        plan: who plans.
    """
    try:
        start = _in_map(request.start, header, 'start') if request.use_start else None
        goal = _in_map(request.goal, header, 'goal')
        route = plan(start, goal, header.stamp.sec + 1e-9 * header.stamp.nanosec)
    except (MessageError, RewardPlannerError) as fault:
        _set_code(result, 'UNKNOWN')
        return result, str(fault)
    result.path = Path(header=header)
    if isinstance(route, NoRouteReason):
        _set_code(result, _CODES[route])
        return result, route.value
    result.path = path_message(route, goal.yaw, header)
    return result, ''


def _in_map(message: Any, header: Header, name: str) -> PlanarPose:
    if message.header.frame_id not in ('', header.frame_id):
        raise MessageError(
            f'{name} is in the frame {message.header.frame_id!r}; give it in {header.frame_id!r}'
        )
    return planar_pose(message.pose, name)


def _set_code(result: Any, name: str) -> None:
    """Set the error code; older versions of the action have none."""
    if hasattr(result, 'error_code'):
        result.error_code = getattr(result, name)
