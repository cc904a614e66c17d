"""Action servers for Nav2's NavigateToPose and FollowPath, if nav2_msgs is installed."""

import math
from functools import partial
from importlib import import_module
from importlib.util import find_spec
from typing import Any, Protocol

from geometry_msgs.msg import PoseStamped
from rclpy.action import ActionServer, CancelResponse, GoalResponse
from rclpy.duration import Duration
from std_msgs.msg import Header

from reward_planner.core.driving.drive_state import DriveCommand, DriveState
from reward_planner.core.driving.replanner import path_length
from reward_planner.core.navigator import Navigator
from reward_planner.core.reward_planner_error import RewardPlannerError
from reward_planner.interface.compute_path_server import NO_ROUTE_CODES, set_error
from shirube_ros.callback_guard import CallbackGuard
from shirube_ros.errors import FrameError
from shirube_ros.managed_node import ManagedNode
from shirube_ros.message_conversion import pose_stamped

NAVIGATE, FOLLOW = 'navigate_to_pose', 'follow_path'
PROBLEM_TIMEOUT = 10.0
"""Time without a route, pose or map, or without motion, after which a goal is aborted [s]."""

_CODES = {
    DriveState.LOST: 'NO_VALID_CONTROL',
    DriveState.MAP_STALE: 'NO_VALID_CONTROL',
    DriveState.UNREACHABLE: 'NO_VALID_CONTROL',
    DriveState.STUCK: 'FAILED_TO_MAKE_PROGRESS',
}
"""Error codes of FollowPath; those without a route are codes of ComputePathToPose in NavigateToPose."""


class DriveTo(Protocol):
    """Sets a goal, on a path or a route of the planner's; errors are those of messages and of the package."""

    def __call__(self, message: PoseStamped, topic: str, path: list[PoseStamped] | None = None) -> None:
        """Set the goal; the topic is its name in error messages."""


class NavigationServer:
    """Drives to goals of actions, one at a time; a new one, also on ``goal_pose``, replaces it.

    A goal is accepted until the control cycle ends it: rclpy would call a waiting coroutine without pause.
    """

    def __init__(
        self, node: ManagedNode, guard: CallbackGuard, navigator: Navigator, drive_to: DriveTo, refusal: str
    ) -> None:
        """Create the servers; a refusal is the reason why the node takes no goals, empty if it does."""
        self._node, self._guard, self._navigator = node, guard, navigator
        self._drive_to, self._refusal = drive_to, refusal
        self._handle: Any = None
        self._name = NAVIGATE
        self._started = self._problem_since = math.nan
        self._goal_count = 0
        if find_spec('nav2_msgs') is None:
            return
        self._actions: Any = import_module('nav2_msgs.action')
        for name, action in ((NAVIGATE, self._actions.NavigateToPose), (FOLLOW, self._actions.FollowPath)):
            ActionServer(
                node,
                action,
                name,
                partial(self._finish, name, 'UNKNOWN', 'not driven'),
                goal_callback=lambda _: self._respond(),
                handle_accepted_callback=lambda handle, name=name: self._accept(name, handle),
                cancel_callback=lambda _: CancelResponse.ACCEPT,
            )

    def update(self, drive: DriveCommand, now: float) -> None:
        """Publish feedback after a control cycle at a time [s], and end a goal that is reached, cancelled or lost."""
        if self._handle is None:
            return
        controller = self._navigator.controller
        if self._goal_count != controller.goal_count:
            self.end('UNKNOWN', 'another goal replaced it')
        elif self._handle.is_cancel_requested:
            controller.cancel_goal()
            self.end('NONE', 'cancelled')
        elif drive.state is DriveState.GOAL_REACHED:
            self.end('NONE', '')
        elif drive.state is DriveState.IDLE:
            self.end('UNKNOWN', 'the goal was cancelled in the node')
        else:
            self._handle.publish_feedback(self._feedback(drive, now))
            self._abort_after_timeout(drive, now)

    def end(self, code: str, message: str) -> None:
        """End the goal, if there is one, with an error code; an empty message is success."""
        if self._handle is None:
            return
        handle, self._handle = self._handle, None
        handle.execute(partial(self._finish, self._name, code, message))

    def _respond(self) -> GoalResponse:
        reason = self._refusal if self._guard.is_active else 'the node is not active; activate it'
        if reason:
            self._node.get_logger().warning(f'goal of an action rejected: {reason}')
        return GoalResponse.REJECT if reason else GoalResponse.ACCEPT

    def _accept(self, name: str, handle: Any) -> None:
        """Drive to a goal that was accepted; the one before is aborted."""
        self.end('UNKNOWN', 'another goal replaced it')
        self._name, self._handle, self._problem_since = name, handle, math.nan
        self._started = self._node.get_clock().now().nanoseconds * 1e-9
        code = 'UNKNOWN'

        def start() -> None:
            nonlocal code
            try:
                self._start(handle.request)
            except FrameError:
                code = 'TF_ERROR'
                raise
            except RewardPlannerError:
                code = 'GOAL_OUTSIDE_MAP' if name == NAVIGATE else 'INVALID_PATH'
                raise

        problem = self._guard.run(name, start)
        self._goal_count = self._navigator.controller.goal_count
        if problem is not None:
            self.end(code, problem)

    def _start(self, request: Any) -> None:
        if self._name == NAVIGATE:
            self._drive_to(request.pose, NAVIGATE)
            return
        if not request.path.poses:
            raise RewardPlannerError('follow_path has a path without poses; give at least one')
        for pose in request.path.poses:
            pose.header.frame_id = pose.header.frame_id or request.path.header.frame_id
        self._drive_to(request.path.poses[-1], FOLLOW, request.path.poses)

    def _abort_after_timeout(self, drive: DriveCommand, now: float) -> None:
        """Abort a goal whose problem lasts."""
        if not drive.state.needs_attention:
            self._problem_since = math.nan
            return
        if math.isnan(self._problem_since):
            self._problem_since = now
        if now - self._problem_since < PROBLEM_TIMEOUT:
            return
        controller, code = self._navigator.controller, _CODES[drive.state]
        if self._name == NAVIGATE and drive.state is DriveState.UNREACHABLE:
            reason = None if controller.replanner is None else controller.replanner.no_route_reason
            code = 'NO_VALID_PATH' if reason is None else NO_ROUTE_CODES[reason]
        controller.cancel_goal()
        self.end(code, drive.detail)

    def _finish(self, name: str, code: str, message: str, handle: Any) -> Any:
        """Set the final state of a goal and return its result; rclpy calls it."""
        planner, controller = self._actions.ComputePathToPose.Result, self._actions.FollowPath.Result
        result = (self._actions.NavigateToPose if name == NAVIGATE else self._actions.FollowPath).Result()
        is_planned = name == NAVIGATE and code not in _CODES.values()
        set_error(result, planner if is_planned else controller, code, message)
        if code != 'NONE':
            self._node.get_logger().warning(f'{name}: {message}')
            handle.abort()
        elif handle.is_cancel_requested:
            handle.canceled()
        else:
            handle.succeed()
        return result

    def _feedback(self, drive: DriveCommand, now: float) -> Any:
        points, pose = self._navigator.controller.points_map, self._navigator.controller.fresh_pose(now)
        to_route = 0.0 if pose is None or not len(points) else math.dist(points[0], (pose.x, pose.y))
        distance = path_length(points) + to_route if len(points) else 0.0
        speed = 0.0 if drive.velocity is None else drive.velocity.forward
        if self._name == FOLLOW:
            return self._actions.FollowPath.Feedback(distance_to_goal=distance, speed=speed)
        feedback = self._actions.NavigateToPose.Feedback(distance_remaining=distance)
        feedback.navigation_time = Duration(seconds=max(now - self._started, 0.0)).to_msg()
        if speed > 0.01:  # m/s, as in Nav2
            feedback.estimated_time_remaining = Duration(seconds=distance / speed).to_msg()
        if pose is not None:
            stamp = self._node.get_clock().now().to_msg()
            frame = self._node.get_parameter('map_frame').value
            feedback.current_pose = pose_stamped(pose, Header(stamp=stamp, frame_id=frame))
        return feedback
