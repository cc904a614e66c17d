"""The node through real topics."""

import json
from threading import Event

import numpy as np
import pytest
from geometry_msgs.msg import PoseStamped
from nav_msgs.msg import OccupancyGrid, Path
from node_robot import AHEAD, CAMERA, ROOM, START, Robot, stamp
from rclpy.parameter import Parameter
from sensor_msgs.msg import CameraInfo, Image
from std_msgs.msg import String

from reward_planner.core.driving.replanner import Replanner
from reward_planner.core.occupancy_map import GridFrame, OccupancyMap
from reward_planner.files.occupancy_map_file import load_occupancy_map, save_occupancy_map
from scene_simulator.room.box_room import forward_camera
from shirube_core.geometry import SE2
from shirube_ros.quality_of_service import map_profile


def test_the_robot_is_driven_around_a_box_to_its_goal(graph):
    robot = Robot(graph, drive=True, max_linear_velocity=1.0, max_linear_acceleration=1.0)
    plans = robot.listen(Path, '/reward_planner/plan')
    waypoints = robot.listen(PoseStamped, '/reward_planner/next_waypoint')
    local_maps = robot.listen(OccupancyGrid, '/reward_planner/local_map', map_profile())
    robot.drive(0.5)
    robot.send_goal(AHEAD)
    robot.drive(60.0, until=lambda: robot.body.pose_at(robot.body.time).distance_to(AHEAD) < 0.1)
    assert robot.body.pose_at(robot.body.time).distance_to(AHEAD) < 0.1
    assert plans[0].header.frame_id == waypoints[0].header.frame_id == 'map'
    assert plans[0].poses[-1].pose.position.x == pytest.approx(3.5)
    assert max(abs(pose.pose.position.y) for plan in plans for pose in plan.poses) > 0.6
    assert 0 in local_maps[-1].data
    assert 100 in local_maps[-1].data
    late = robot.listen(OccupancyGrid, '/reward_planner/map', map_profile())
    assert graph.spin_until(lambda: len(late) > 0)
    cells = np.array(late[-1].data, dtype=np.int8).reshape(late[-1].info.height, late[-1].info.width)
    x, y = late[-1].info.origin.position.x, late[-1].info.origin.position.y
    assert (cells[int((0.0 - y) / 0.1), int((1.0 - x) / 0.1)], late[-1].header.frame_id) == (0, 'map')
    assert (cells[int((-1.0 - y) / 0.1) :, int((1.65 - x) / 0.1)] == 100).any()


def test_the_local_map_bears_the_time_of_its_frame(graph):
    robot = Robot(graph)
    maps = robot.listen(OccupancyGrid, '/reward_planner/local_map', map_profile())
    robot.send_pose()
    robot.tick(0.1)
    robot.send_points()
    seen_at = robot.now
    robot.tick(0.2)
    robot.send_pose()
    robot.tick(0.1)
    assert graph.spin_until(lambda: len(maps) == 1)
    assert maps[0].header.stamp == stamp(seen_at)
    assert maps[0].header.frame_id == 'map'


def test_lamps_are_obeyed(graph):
    robot = Robot(graph, drive=True)
    robot.drive_to(AHEAD, 1.5)
    fields = {'beacon': 3, 'counter': 7, 'op': 'stop', 'value': 0.0}
    robot.send('command', String(data=json.dumps(fields)))
    robot.drive(2.0)
    assert graph.spin_until(lambda: abs(robot.speed) < 1e-3)
    assert robot.message().message == 'stopped on command of a lamp'


def test_depth_images_are_mapped(graph):
    robot = Robot(graph, source='depth')
    info = CameraInfo(width=80, height=60, k=[60.0, 0.0, 39.5, 0.0, 60.0, 29.5, 0.0, 0.0, 1.0])
    depth = ROOM.depth_image(CAMERA, forward_camera(0.0, 0.0, 0.3, 0.0)).astype(np.float32)
    image = Image(width=80, height=60, encoding='32FC1', step=320, data=depth.tobytes())
    image.header = robot.header('camera_optical_frame')
    robot.send('depth/image', image)
    assert robot.refusals('depth/image') == [
        'depth/image was received without a valid depth/camera_info; publish the calibration'
    ]
    robot.send('depth/camera_info', info)
    for _ in range(3):
        image.header = robot.header('camera_optical_frame')
        robot.send('depth/image', image)
        robot.send_pose(START)
        robot.tick(0.1)
    assert graph.spin_until(lambda: robot.node._report._frames == 3)
    grid, cells = robot.node._navigator.mapper.map.occupancy()
    row, column = grid.cell_of((1.65, 0.0))
    assert cells[row, column] == 100


def test_the_map_is_saved_resumed_and_cleared(graph, tmp_path):
    path = tmp_path / 'hall.yaml'
    cells = np.full((64, 64), 0, dtype=np.int8)
    cells[10, 20] = 100
    save_occupancy_map(path, OccupancyMap(GridFrame(0.0, 0.0, 0.1, 64, 64), cells))
    robot = Robot(graph, map_file=str(path), save_file=str(tmp_path / 'new.yaml'))
    maps = robot.listen(OccupancyGrid, '/reward_planner/map', map_profile())
    robot.tick(1.1)
    assert graph.spin_until(lambda: len(maps) > 0)
    np.testing.assert_array_equal(np.array(maps[0].data, dtype=np.int8).reshape(64, 64), cells)
    assert robot.call('save_map').success
    np.testing.assert_array_equal(load_occupancy_map(tmp_path / 'new.yaml', 0.1).occupancy, cells)
    assert robot.call('clear_map').success
    answer = robot.call('save_map')
    assert (answer.success, answer.message) == (False, 'the map is empty; wait for the first frame')
    late = robot.listen(OccupancyGrid, '/reward_planner/map', map_profile())
    assert graph.spin_until(lambda: len(late) > 0)
    assert set(late[-1].data) == {-1}


def test_each_goal_gets_its_plan_and_a_latecomer_the_newest(graph):
    robot = Robot(graph)
    plans = robot.listen(Path, '/reward_planner/plan')
    robot.drive(0.3)
    goals = [SE2(1.0, -1.5 + 0.3 * k, 0.0) for k in range(10)]
    for goal in goals:
        robot.send_goal(goal)
        robot.drive(0.2)
    expected = {round(goal.y, 3) for goal in goals}
    assert graph.spin_until(
        lambda: {round(plan.poses[-1].pose.position.y, 3) for plan in plans if plan.poses} == expected
    )
    late = robot.listen(Path, '/reward_planner/plan', map_profile())
    assert graph.spin_until(lambda: len(late) > 0)
    assert late[-1].poses[-1].pose.position.y == pytest.approx(goals[-1].y)
    assert robot.velocities == []  # without drive nothing is driven
    assert robot.robot.count_publishers('/cmd_vel') == 0


def test_without_a_route_the_robot_recovers_and_then_gives_up_with_the_reason(graph, tmp_path, capfd):
    cells = np.zeros((60, 100), dtype=np.int8)
    cells[[9, 50], 9:71] = cells[9:51, [9, 70]] = 100  # the walls of the room
    save_occupancy_map(tmp_path / 'hall.yaml', OccupancyMap(GridFrame(-2.0, -3.0, 0.1, 100, 60), cells))
    values = {'recovery': 'clear wait', 'recovery_wait': 0.5, 'map_file': str(tmp_path / 'hall.yaml')}
    robot = Robot(graph, drive=True, **values)
    robot.drive_to(SE2(6.5, 0.0, 0.0), 5.0)
    reason = 'no path to the goal: obstacles block every path'
    status = robot.message()
    assert status.message == f'{reason}; tried clear, wait'
    assert ('recovery', 'clear, wait') in [(each.key, each.value) for each in status.values]
    lines = capfd.readouterr().err
    assert f'recovering: clear ({reason})' in lines
    assert f'recovering: wait ({reason})' in lines


def test_a_fault_of_the_driver_stops_the_robot(graph, monkeypatch):
    robot = Robot(graph, drive=True)
    robot.drive_to(AHEAD)
    assert robot.speed > 0.0

    def fail(_):
        raise RuntimeError('no driver')

    monkeypatch.setattr(robot.node._navigator.controller, 'step', fail)
    robot.tick(0.2)
    assert graph.spin_until(lambda: robot.speed == 0.0)


def test_while_a_route_is_computed_the_robot_stands_and_commands_go_on(graph, monkeypatch):
    release, update = Event(), Replanner.update

    def update_late(*arguments, **options):
        assert release.wait(20.0)
        update(*arguments, **options)

    robot = Robot(graph, drive=True, planning_thread=True)
    monkeypatch.setattr(Replanner, 'update', update_late)
    robot.drive_to(AHEAD)
    assert robot.message().message == 'planning'
    assert len(robot.velocities) >= 8
    assert robot.speed == 0.0
    release.set()
    assert graph.spin_until(robot.node._navigator.controller.replanner._future.done)
    robot.drive(1.0, until=lambda: robot.speed > 0.0)
    assert robot.speed > 0.0
    release.clear()
    robot.node.trigger_deactivate()  # does not wait for the cycle that runs
    release.set()
    robot.node.trigger_activate()
    robot.drive_to(AHEAD)
    robot.drive(2.0, until=lambda: robot.speed > 0.0)
    assert robot.speed > 0.0


def test_a_lower_speed_limit_and_deactivation_hold_at_once(graph):
    robot = Robot(graph, drive=True)
    robot.drive_to(AHEAD, 1.5)
    assert robot.speed > 0.2
    results = robot.node.set_parameters(
        [Parameter('max_linear_velocity', value=0.1), Parameter('robot_radius', value=0.25)]
    )
    assert all(result.successful for result in results)
    robot.drive(1.5)
    assert 0.0 < robot.speed <= 0.1
    robot.node.trigger_deactivate()
    assert graph.spin_until(lambda: robot.speed == 0.0)
    seen = len(robot.velocities)
    robot.tick(0.3)
    robot.node.trigger_activate()
    robot.drive(0.5)  # the goal is cancelled
    assert {message.twist.linear.x for message in robot.velocities[seen:]} <= {0.0}


def test_the_robot_stops_while_simulated_time_is_paused(graph):
    robot = Robot(graph, drive=True)
    robot.drive_to(AHEAD)
    assert robot.speed > 0.0
    assert graph.spin_until(lambda: robot.speed == 0.0, timeout=3.0)
    robot.drive(1.0)
    assert robot.speed > 0.0
    robot.node.stop()  # as when the node ends
    assert graph.spin_until(lambda: robot.speed == 0.0)
