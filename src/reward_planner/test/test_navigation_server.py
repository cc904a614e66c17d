"""The node drives to goals of Nav2's actions, with stand-ins for the messages of nav2_msgs and rclpy's server."""

from types import SimpleNamespace

import pytest
from nav_msgs.msg import Path
from node_robot import START, Robot
from rclpy.action import CancelResponse, GoalResponse

from reward_planner.interface import compute_path_server, navigation_server
from shirube_core.geometry import SE2
from shirube_ros.message_conversion import pose_stamped

PLANNER = {'NONE': 0, 'UNKNOWN': 200, 'TF_ERROR': 202, 'GOAL_OUTSIDE_MAP': 204, 'NO_VALID_PATH': 208}
CONTROLLER = {
    'NONE': 0, 'UNKNOWN': 100, 'TF_ERROR': 102, 'INVALID_PATH': 103, 'FAILED_TO_MAKE_PROGRESS': 105,
    'NO_VALID_CONTROL': 106,
}  # fmt: skip
NEAR = SE2(0.9, 0.0, 0.0)


def action(**codes):
    result = type('Result', (), {**codes, 'error_code': 0, 'error_msg': ''})
    return SimpleNamespace(Result=result, Feedback=SimpleNamespace)


class Handle:
    """A goal of a client."""

    def __init__(self, request):
        self.request, self.status, self.result, self.feedback = request, 'accepted', None, []
        self.is_cancel_requested = False

    def execute(self, callback):
        self.result = callback(self)

    def succeed(self):
        self.status = 'succeeded'

    def abort(self):
        self.status = 'aborted'

    def canceled(self):
        self.status = 'canceled'

    def publish_feedback(self, feedback):
        self.feedback.append(feedback)


class Servers(dict):
    """Stands in for rclpy's ActionServer; its instances are found by the action's name."""

    def __call__(self, _node, _action, name, _execute, **callbacks):
        self[name] = callbacks

    def send(self, name, request):
        if self[name]['goal_callback'](request) is not GoalResponse.ACCEPT:
            return None
        handle = Handle(request)
        self[name].get('handle_accepted_callback', lambda _: None)(handle)
        return handle


@pytest.fixture
def servers(monkeypatch):
    made = Servers()
    actions = SimpleNamespace(
        ComputePathToPose=action(**PLANNER), NavigateToPose=action(NONE=0), FollowPath=action(**CONTROLLER)
    )
    for module in (compute_path_server, navigation_server):
        monkeypatch.setattr(module, 'find_spec', lambda _: True)
        monkeypatch.setattr(module, 'import_module', lambda _: actions)
        monkeypatch.setattr(module, 'ActionServer', made)
    return made


def to(robot, goal, frame='map'):
    return SimpleNamespace(pose=pose_stamped(goal, robot.header(frame)))


def along(robot, *places, frame='map'):
    header = robot.header(frame)
    return SimpleNamespace(path=Path(header=header, poses=[pose_stamped(each, header) for each in places]))


def test_a_goal_is_reached_with_feedback(graph, servers):
    robot = Robot(graph, drive=True)
    robot.drive(0.5)
    handle = servers.send('navigate_to_pose', to(robot, NEAR))
    robot.drive(20.0, until=lambda: handle.result is not None)
    assert (handle.status, handle.result.error_code) == ('succeeded', 0)
    assert robot.body.pose_at(robot.body.time).distance_to(NEAR) < 0.1
    distances = [each.distance_remaining for each in handle.feedback[1:]]
    assert 0.7 < max(distances) < 1.1
    assert distances[-1] < 0.2
    last = handle.feedback[-1]
    assert last.navigation_time.sec >= 1
    estimates = [each.estimated_time_remaining for each in handle.feedback if hasattr(each, 'estimated_time_remaining')]
    assert 1 <= max(estimate.sec for estimate in estimates[5:]) < 10
    assert last.current_pose.pose.position.x == pytest.approx(0.9, abs=0.15)
    assert last.current_pose.header.frame_id == 'map'


def test_a_cancelled_goal_stops_the_robot_and_a_new_one_aborts_it(graph, servers):
    robot = Robot(graph, drive=True)
    robot.drive(0.5)
    first = servers.send('navigate_to_pose', to(robot, NEAR))
    robot.drive(1.0)
    assert robot.speed > 0.05
    second = servers.send('navigate_to_pose', to(robot, SE2(1.0, 0.0, 0.0)))
    assert (first.status, first.result.error_msg) == ('aborted', 'another goal replaced it')
    assert servers['navigate_to_pose']['cancel_callback'](second) is CancelResponse.ACCEPT
    second.is_cancel_requested = True
    robot.drive(2.0)
    assert (second.status, robot.speed) == ('canceled', 0.0)
    third = servers.send('navigate_to_pose', to(robot, NEAR))
    robot.send_goal(NEAR)
    robot.cycle()
    assert third.status == 'aborted'


def test_errors_have_nav2s_codes(graph, servers):
    robot = Robot(graph, drive=True)
    robot.drive(0.3)
    for name, request, code in (
        ('navigate_to_pose', to(robot, NEAR, 'odom'), 202),
        ('follow_path', along(robot, NEAR, frame='odom'), 102),
        ('follow_path', along(robot), 103),
    ):
        handle = servers.send(name, request)
        assert (handle.status, handle.result.error_code) == ('aborted', code)
    handle = servers.send('navigate_to_pose', to(robot, NEAR))
    for _ in range(round(10 * navigation_server.PROBLEM_TIMEOUT) + 30):  # neither poses nor frames
        robot.cycle()
    assert (handle.status, handle.result.error_code) == ('aborted', 106)


def test_a_path_is_followed_as_it_is(graph, servers):
    robot = Robot(graph, drive=True)
    robot.drive(0.5)
    places = (START, SE2(0.5, 0.5, 0.0), SE2(0.9, 0.4, 0.0))
    handle = servers.send('follow_path', along(robot, *places))
    ys = []
    for _ in range(200):
        robot.drive(0.1)
        ys.append(robot.body.pose_at(robot.body.time).y)
        if handle.result is not None:
            break
    assert (handle.status, handle.result.error_code) == ('succeeded', 0)
    assert max(ys) == pytest.approx(0.45, abs=0.1)
    assert robot.body.pose_at(robot.body.time).distance_to(places[-1]) < 0.1
    assert handle.feedback[5].speed > 0.0


def test_an_inactive_node_and_one_that_does_not_drive_reject_goals(graph, servers):
    robot = Robot(graph)
    assert servers.send('navigate_to_pose', to(robot, NEAR)) is None
    assert servers.send('compute_path_to_pose', None) is not None
    robot.node.trigger_deactivate()
    assert servers.send('compute_path_to_pose', None) is None
