"""Errors are reported in one line, and the robot stops."""

import math

import numpy as np
import pytest
from builtin_interfaces.msg import Time
from diagnostic_msgs.msg import DiagnosticStatus
from memory_tf import MemoryTf
from node_robot import AHEAD, START, Robot
from node_testing import cloud_from_points, run_in_process
from sensor_msgs.msg import PointCloud2
from std_msgs.msg import Header, String

from reward_planner.core.occupancy_map import GridFrame, OccupancyMap
from reward_planner.core.reward_planner_error import RewardPlannerError
from reward_planner.files.occupancy_map_file import save_occupancy_map
from reward_planner.node import RewardPlannerNode, main
from shirube_core.geometry import SE2
from shirube_ros.message_conversion import pose_stamped

pytestmark = pytest.mark.newest_set_only


BAD_MESSAGES = (
    (lambda r: r.send_points('lidar'), 'points', "points is in the unknown frame 'lidar'"),
    (lambda r: r.send_points(''), 'points', "points is in the unknown frame ''"),
    (lambda r: r.send('points', PointCloud2(header=r.header('base_link'))), 'points',
     'points has no field x; send x, y and z'),
    (lambda r: r.send_pose(START, 'odom'), 'pose', "pose is in the frame 'odom', map_frame is 'map'"),
    (lambda r: r.send_pose(SE2(math.nan, 0.0, 0.0)), 'pose', 'pose holds a pose that is not finite'),
    (lambda r: r.send_goal(START, 'odom'), 'goal_pose', "goal_pose is in the frame 'odom'"),
    (lambda r: r.send_goal(SE2(math.inf, 0.0, 0.0)), 'goal_pose', 'goal_pose holds a pose that is not'),
    (lambda r: r.send('command', String(data='stop!')), 'command', 'command is not valid JSON'),
    (lambda r: r.send('command', String(data='{"op": "fly"}')), 'command', 'command has an unknown op'),
)  # fmt: skip


def test_a_bad_message_is_refused_with_one_line(graph):
    robot = Robot(graph)
    for send, topic, words in BAD_MESSAGES:
        known = robot.refusals(topic)
        send(robot)
        (line,) = robot.refusals(topic)[len(known) :]
        assert line.startswith(words)
        assert '\n' not in line
    robot.send_pose()
    assert robot.message().level != DiagnosticStatus.ERROR


@pytest.mark.parametrize(
    ('goal', 'frame', 'words'),
    [
        (SE2(2.5, 0.0, 0.0), 'odom', "goal_pose is in the frame 'odom', map_frame is 'map'"),
        (SE2(math.nan, 0.0, 0.0), 'map', 'goal_pose holds a pose that is not finite'),
        (SE2(30.0, 0.0, 0.0), 'map', 'the goal at x 30.00 m, y 0.00 m is outside of the map, which extends from'),
    ],
)
def test_a_refused_goal_does_not_cancel_the_current_one(graph, tmp_path, goal, frame, words):
    path = tmp_path / 'hall.yaml'
    cells = np.zeros((20, 40), dtype=np.int8)
    save_occupancy_map(path, OccupancyMap(GridFrame(-1.0, -1.0, 0.1, 40, 20), cells))
    robot = Robot(graph, drive=True, map_file=str(path))
    robot.drive_to(SE2(2.5, 0.0, 0.0))
    assert robot.speed > 0.0
    robot.send_goal(goal, frame)
    (line,) = robot.refusals('goal_pose')
    assert line.startswith(words)
    assert '\n' not in line
    robot.drive(0.5)
    assert robot.speed > 0.0
    assert robot.node._navigator.controller.goal == SE2(2.5, 0.0, 0.0)


def test_a_goal_in_a_frame_of_tf_is_where_it_is_in_the_map(graph, monkeypatch):
    tf = MemoryTf(monkeypatch)
    tf.join('map', 'odom', (1.0, 0.5, 0.0), (0.0, 0.0, math.pi / 2.0))
    robot = Robot(graph)
    robot.send_goal(SE2(-0.5, -1.0, 0.0), 'odom')
    assert robot.refusals('goal_pose') == []
    goal = robot.node._navigator.controller.goal
    assert (goal.x, goal.y, goal.yaw) == pytest.approx((2.0, 0.0, math.pi / 2.0))


def test_frames_of_nan_do_not_keep_the_robot_driving(graph):
    robot = Robot(graph, drive=True)
    robot.drive_to(AHEAD, 1.5)
    assert robot.speed > 0.0
    for _ in range(30):
        points = np.full((50, 3), np.nan, dtype=np.float32)
        robot.send('points', cloud_from_points(points, robot.header('camera_optical_frame')))
        robot.send_pose()
        robot.tick(0.1)
    assert graph.spin_until(lambda: abs(robot.speed) < 1e-3)
    assert any('no finite point' in line for line in robot.refusals('control loop'))
    assert 'the map is out of date' in robot.message().message


def test_a_pose_that_jumps_stops_the_robot_until_poses_agree(graph, capfd):
    robot = Robot(graph, drive=True)
    robot.drive_to(AHEAD, 1.5)
    for _ in range(6):
        robot.send_pose(SE2(4.0, 1.5, 0.0))
        robot.tick(0.1)
    assert 'the pose jumped' in robot.message().message
    for _ in range(8):
        robot.send_pose(SE2(4.0, 1.5, 0.0))
        robot.tick(0.1)
    words = capfd.readouterr().err
    assert 'the pose jumped; the robot stops' in words
    assert 'poses are consistent again, at x 4.00 m, y 1.50 m' in words


def test_when_time_jumps_back_the_robot_stops_without_a_goal(graph, capfd):
    robot = Robot(graph, drive=True)
    assert 'compiling numba kernels (first start only' in capfd.readouterr().err
    robot.drive_to(AHEAD)
    robot.tick(-50.0)
    robot.send_pose(START)
    robot.send_pose(START)
    assert robot.node._navigator.controller.replanner is None
    assert capfd.readouterr().err.count('clock jumped back') == 1


def test_when_time_jumps_back_images_of_both_runs_are_not_mixed(graph):
    node = graph.add(RewardPlannerNode, source='trinocular')
    for name in ('left', 'right'):
        assert node._groups.put(name, 5.0, 'old') is None
    for nanosec in (9, 1, 2, 3, 4, 5):
        header = Header(stamp=Time(sec=9 if nanosec == 9 else 5, nanosec=nanosec), frame_id='map')
        node._guard.run('pose', lambda header=header: node._take_pose(pose_stamped(START, header)))
    assert node._groups.put('top', 5.0, 'new') is None


def test_a_late_cloud_and_a_late_pose_are_counted_and_reset_nothing(graph, capfd):
    robot = Robot(graph, drive=True)
    robot.drive_to(AHEAD, 1.5)
    robot.send_points(ago=2.0)
    robot.send('pose', pose_stamped(START, robot.header(ago=1.5)))
    for topic in ('points', 'pose'):
        (line,) = robot.refusals(topic)
        assert line.startswith(f'{topic} came out of order or late')
    robot.drive(0.5)
    assert robot.speed > 0.0
    assert 'clock jumped' not in capfd.readouterr().err


def test_a_pose_that_is_not_of_now_does_not_stop_the_robot(graph):
    robot = Robot(graph, drive=True)
    robot.drive_to(AHEAD, 1.5)
    for ago in (robot.now, -50.0):
        robot.send('pose', pose_stamped(START, robot.header(ago=ago)))
        robot.drive(0.3)
        assert robot.speed > 0.0
    lines = robot.refusals('pose')
    assert [line.startswith('pose has a stamp') for line in lines] == [True] * 2


@pytest.mark.parametrize(
    ('parameters', 'words'),
    [
        ({'resolution': 0.2}, 'resolution is 0.1 m, it must be 0.2 m'),
        ({'map_file': '/no/such/map.yaml'}, '/no/such/map.yaml: cannot be read'),
        ({'save_file': 'hall.pgm'}, 'hall.pgm: is not a name for the YAML file of a map'),
        ({'height_min': 2.0}, 'height_min is 2, it must be lower'),
        ({'footprint': [0.1, 0.1, 0.5, 0.1, 0.5, 0.4]}, 'footprint does not contain the origin of base_frame'),
        ({'log_odds_occupied': 4.0}, 'log_odds_occupied is 4, it may not be more; log_odds_max is 3.5'),
        ({'recovery': 'wait dance'}, "recovery is 'wait dance'; give names of look_around, wait"),
        ({'source': 'trinocular', 'depth.block': 4}, 'disparities is 64 and block 4'),
    ],
)
def test_maps_and_heights_that_do_not_fit_are_refused(graph, tmp_path, parameters, words):
    path = tmp_path / 'hall.yaml'
    cells = np.zeros((8, 8), dtype=np.int8)
    save_occupancy_map(path, OccupancyMap(GridFrame(0.0, 0.0, 0.1, 8, 8), cells))
    with pytest.raises(RewardPlannerError, match=words):
        graph.add(RewardPlannerNode, **({'map_file': str(path), 'resolution': 0.1} | parameters))


def test_a_map_that_cannot_be_saved_is_an_answer_and_the_node_goes_on(graph, monkeypatch):
    robot = Robot(graph, save_file='/proc/hall.yaml')
    robot.drive(0.3)
    answer = robot.call('save_map')
    assert (answer.success, answer.message[:18]) == (False, '/proc/hall.yaml: N')

    def fail(*_):
        raise ZeroDivisionError('a mistake')

    monkeypatch.setattr('reward_planner.interface.map_server.save_global_map', fail)
    for _ in range(2):
        answer = robot.call('save_map')
        assert (answer.success, answer.message) == (False, 'ZeroDivisionError: a mistake')


def test_a_bad_start_is_one_line_and_exit_code_1(capfd):
    assert run_in_process(main, '--ros-args', '-p', 'map_file:=/no/such/map.yaml') == 1
    said = capfd.readouterr().err.splitlines()
    (line,) = (line for line in said if not line.startswith(('[INFO]', '[WARN]')))
    assert '/no/such/map.yaml: cannot be read' in line
