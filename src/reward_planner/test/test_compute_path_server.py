"""The action server for Nav2, with stand-ins for the messages of nav2_msgs."""

from types import SimpleNamespace

import numpy as np
import pytest
from nav_msgs.msg import Path
from rclpy.node import Node
from std_msgs.msg import Header

from reward_planner.core.driving.route_planning import run_at_once
from reward_planner.core.navigator import Navigator, NavigatorSettings
from reward_planner.core.occupancy_map import GridFrame, OccupancyMap
from reward_planner.core.reward_planner_error import DrivingError
from reward_planner.core.route.route import NoRoute
from reward_planner.core.settings import VoxelSettings
from reward_planner.interface.compute_path_server import create_compute_path_server, handle_request
from shirube_core.geometry import SE2, CameraMount
from shirube_ros.callback_guard import CallbackGuard
from shirube_ros.errors import FrameError
from shirube_ros.message_conversion import planar_pose, pose_stamped

HEADER = Header(frame_id='map')
CODES = {'NONE': 0, 'UNKNOWN': 200, 'INVALID_PLANNER': 201, 'TF_ERROR': 202, 'START_OUTSIDE_MAP': 203}
CODES |= {'GOAL_OUTSIDE_MAP': 204, 'START_OCCUPIED': 205, 'GOAL_OCCUPIED': 206, 'NO_VALID_PATH': 208}


def navigator():
    made = Navigator(CameraMount(), NavigatorSettings(voxels=VoxelSettings(resolution=0.1)))
    cells = np.zeros((60, 60), dtype=np.int8)
    cells[20:40, 28:32] = 100
    made.set_static_map(OccupancyMap(GridFrame(0.0, 0.0, 0.1, 60, 60), cells))
    return made


def in_map(message, name):
    if message.header.frame_id != 'map':
        raise FrameError(f'{name} is in the frame {message.header.frame_id!r}')
    return planar_pose(message.pose, name)


def ask(planner, goal, start=None, frame='map', planner_id=''):
    request = SimpleNamespace(
        start=pose_stamped(start or SE2(0.0, 0.0, 0.0), Header(frame_id=frame)),
        goal=pose_stamped(goal, Header(frame_id=frame)),
        use_start=start is not None,
        planner_id=planner_id,
    )
    result = SimpleNamespace(path=Path(), error_code=0, error_msg='', **CODES)
    return handle_request(request, result, HEADER, in_map, planner.route_between)


def test_a_route_around_the_obstacle_is_answered():
    result, problem = ask(navigator(), SE2(5.0, 3.0, 0.5), SE2(1.0, 3.0, 0.0))
    assert (problem, result.error_code, result.path.header.frame_id) == ('', 0, 'map')
    places = np.array([(p.pose.position.x, p.pose.position.y) for p in result.path.poses])
    assert np.hypot(*(places[0] - (1.0, 3.0))) < 0.1
    assert places[-1].tolist() == [5.0, 3.0]
    assert result.planning_time.nanosec > 0
    assert np.abs(places[:, 1] - 3.0).max() > 1.2


def test_the_route_begins_where_the_robot_is_now():
    planner = navigator()
    assert 'pose is unknown' in ask(planner, SE2(5.0, 3.0, 0.0))[1]
    planner.add_pose(-3600.0, SE2(1.0, 5.0, 0.0))
    assert 'too old' in ask(planner, SE2(5.0, 3.0, 0.0))[1]
    planner.add_pose(0.2, SE2(1.0, 5.0, 0.0))
    result, _ = ask(planner, SE2(5.0, 3.0, 0.0))
    assert result.path.poses[0].pose.position.y == pytest.approx(5.0, abs=0.1)


def test_errors_are_reported_by_line_and_code():
    planner, start = navigator(), SE2(1.0, 3.0, 0.0)
    outside = SE2(9.0, 3.0, 0.0)
    for goal, begin, frame, code, words in (
        (SE2(3.0, 3.0, 0.0), start, 'map', 206, NoRoute.GOAL_BLOCKED.value),
        (SE2(5.0, 3.0, 0.0), start, 'odom', 202, "start is in the frame 'odom'"),
        (outside, start, 'map', 204, NoRoute.GOAL_OUTSIDE.value),
        (start, outside, 'map', 203, NoRoute.START_OUTSIDE.value),
    ):
        result, problem = ask(planner, goal, begin, frame)
        assert (result.error_code, result.error_msg, problem) == (code, words, words)
    result, problem = ask(planner, start, start, planner_id='GridBased')
    assert (result.error_code, 'leave it empty' in problem) == (201, True)
    planner.clear_map()
    with pytest.raises(DrivingError, match='give a nearer goal'):
        planner.route_between(start, SE2(1e7, 0.0, 0.0), 0.0)


def test_without_nav2_there_is_no_action(graph):
    node = graph.add(lambda **options: Node('host', **options))
    assert create_compute_path_server(node, CallbackGuard(node), in_map, navigator().route_between, run_at_once) is None
