"""Action server for Nav2's ComputePathToPose, if nav2_msgs is installed."""

from collections.abc import Callable
from concurrent.futures import Future, ThreadPoolExecutor
from functools import partial
from importlib import import_module
from importlib.util import find_spec
from time import perf_counter
from typing import Any, TypeVar

import numpy as np
from geometry_msgs.msg import PoseStamped
from nav_msgs.msg import Path
from numpy.typing import NDArray
from rclpy.action import ActionServer, GoalResponse
from rclpy.duration import Duration
from rclpy.node import Node
from std_msgs.msg import Header

from reward_planner.core.driving.route_planning import run_at_once
from reward_planner.core.reward_planner_error import RewardPlannerError
from reward_planner.core.route.route import NoRoute, thin_path
from shirube_core.geometry import SE2
from shirube_ros.callback_guard import CallbackGuard
from shirube_ros.errors import FrameError, MessageError
from shirube_ros.message_conversion import path_message

_THREADS = 2  # the route to a new goal does not wait for that to the previous one

Result = TypeVar('Result')


class PlanningThread:
    """Starts threads with the first work and ends them with `end`."""

    def __init__(self, *, is_used: bool) -> None:
        """Start without threads; if they are not used, work is done at once."""
        self._is_used = is_used
        self._executor: ThreadPoolExecutor | None = None

    def run(self, work: Callable[[], Result]) -> Future[Result]:
        """Run a function in a thread."""
        if not self._is_used:
            return run_at_once(work)
        if self._executor is None:
            self._executor = ThreadPoolExecutor(_THREADS, thread_name_prefix='planning')
        return self._executor.submit(work)

    def end(self) -> None:
        """End the threads after their present work, without waiting."""
        if self._executor is not None:
            self._executor.shutdown(wait=False, cancel_futures=True)
            self._executor = None


PlanRoute = Callable[[SE2 | None, SE2, float], NDArray[np.float64] | NoRoute]
"""Plans from a start (None for the robot's pose at a time [s]) to a goal: points [m], shape (n, 2), or a reason."""

InMap = Callable[[PoseStamped, str], SE2]
"""Returns a pose, whose name is given, in the map; a FrameError if there is no transform."""

Answer = Future[tuple[Any, str]]
RunAnswer = Callable[[Callable[[], tuple[Any, str]]], Answer]
"""Starts to answer a request, at once or in another thread."""

PLANNER_IDS = ('', 'reward_planner')
_TOLERANCE = 0.02  # of the far part of a long path [m]
_NAME = 'compute_path_to_pose'
NO_ROUTE_CODES = {
    NoRoute.START_OUTSIDE: 'START_OUTSIDE_MAP',
    NoRoute.GOAL_OUTSIDE: 'GOAL_OUTSIDE_MAP',
    NoRoute.START_BLOCKED: 'START_OCCUPIED',
    NoRoute.GOAL_BLOCKED: 'GOAL_OCCUPIED',
    NoRoute.UNREACHABLE: 'NO_VALID_PATH',
    NoRoute.GAVE_UP: 'NO_VALID_PATH',
}


def create_compute_path_server(
    node: Node, guard: CallbackGuard, in_map: InMap, plan: PlanRoute, run: RunAnswer
) -> ActionServer | None:
    """Create the action server of a node, which answers in another thread; None if nav2_msgs is not installed."""
    if find_spec('nav2_msgs') is None:
        return None
    action = import_module('nav2_msgs.action').ComputePathToPose

    def accept(handle: Any) -> None:
        frame = node.get_parameter('map_frame').value
        header = Header(stamp=node.get_clock().now().to_msg(), frame_id=frame)
        answer = run(lambda: handle_request(handle.request, action.Result(), header, in_map, plan))
        answer.add_done_callback(lambda done: handle.execute(partial(finish, done)))

    def finish(done: Answer, handle: Any) -> Any:
        result, problem = (action.Result(), 'the node was deactivated') if done.cancelled() else done.result()
        if problem:
            node.get_logger().warning(f'{_NAME}: {problem}')
            handle.abort()
        else:
            handle.succeed()
        return result

    def respond(_: Any) -> GoalResponse:
        return GoalResponse.ACCEPT if guard.is_active else GoalResponse.REJECT

    return ActionServer(
        node, action, _NAME, lambda _: action.Result(), goal_callback=respond, handle_accepted_callback=accept
    )


def handle_request(request: Any, result: Any, header: Header, in_map: InMap, plan: PlanRoute) -> tuple[Any, str]:
    """Fill the result of the action; return it with a one-line error, empty on success.

    The header has the stamp of the result and the frame of the map.
    """
    began, code, problem = perf_counter(), 'NONE', ''
    result.path = Path(header=header)
    try:
        if request.planner_id not in PLANNER_IDS:
            code = 'INVALID_PLANNER'
            raise MessageError(f'planner_id is {request.planner_id!r}; leave it empty or give reward_planner')
        start = in_map(request.start, 'start') if request.use_start else None
        goal = in_map(request.goal, 'goal')
        route = plan(start, goal, header.stamp.sec + 1e-9 * header.stamp.nanosec)
        if isinstance(route, NoRoute):
            code, problem = NO_ROUTE_CODES[route], route.value
        else:
            result.path = path_message(thin_path(route, _TOLERANCE), goal.yaw, header)
    except FrameError as fault:
        code, problem = 'TF_ERROR', str(fault)
    except (MessageError, RewardPlannerError) as fault:
        code, problem = 'UNKNOWN' if code == 'NONE' else code, str(fault)
    set_error(result, result, code, problem)
    result.planning_time = Duration(seconds=perf_counter() - began).to_msg()
    return result, problem


def set_error(result: Any, codes: Any, name: str, message: str) -> None:
    """Set code and message of an error by its name; versions of the actions differ in what they have."""
    if hasattr(result, 'error_code'):
        result.error_code = getattr(codes, name, getattr(codes, 'UNKNOWN', 0))
    if hasattr(result, 'error_msg'):
        result.error_msg = message
