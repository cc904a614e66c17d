"""Invalid messages and parameters are reported in one line and leave the pose unchanged."""

import math

import numpy as np
import pytest
from arbiter_graph import NOISE, Robot
from nav_msgs.msg import Odometry
from node_testing import run_in_process

from pose_arbiter.node import PoseArbiterNode, main
from shirube_core.geometry import SE2
from shirube_core.settings import SettingsError
from shirube_ros import input_watch
from shirube_ros.message_conversion import pose_stamped, pose_with_covariance_stamped

pytestmark = pytest.mark.newest_set_only


def flat(message):
    message.pose.orientation.w = message.pose.orientation.z = 0.0
    return message


@pytest.mark.parametrize(
    ('send', 'name', 'words'),
    [
        (lambda r: r.publish_a(frame='hall'), 'a', "poses of a have frame_id 'hall', expected 'map'"),
        (lambda r: r.publish_a(SE2(math.nan, 0.0, 0.0)), 'a', 'a holds a pose that is not finite'),
        (lambda r: r.publish_a(noise=np.zeros((3, 3))), 'a', 'a holds a covariance that is not positive'),
        (lambda r: r.publish_a(noise=np.eye(3) * 1e9), 'a', 'a: covariance is invalid'),
        (lambda r: r.publish_a(SE2(1e9, 0.0, 0.0)), 'a', 'a: farther than 1000 km from the origin'),
        (lambda r: r.publish_a(ago=r.now), 'a', 'a: stamp is 0'),
        (lambda r: r.publish_a(ago=-5.0), 'a', 'a: stamp is in the future'),
        (lambda r: r.publish_a(ago=50.0), 'a', 'a: stamp is too old'),
        (lambda r: [r.publish_a(), r.publish_a()], 'a', 'a: duplicate stamp'),
        (lambda r: r.send('b', flat(pose_stamped(r.pose, r.header()))), 'b', 'b holds a quaternion of zeros'),
        (lambda r: r.send('odom', Odometry(header=r.header('odom'))), 'odom', None),
        (lambda r: r.send('odom', Odometry(header=r.header('hall'))), 'odom',
         "odometry has frame_id 'hall', expected 'odom'"),
        (lambda r: r.publish_odometry(SE2(math.inf, 0.0, 0.0)), 'odom', 'odom holds a pose that is not'),
        (lambda r: r.send('initialpose', pose_with_covariance_stamped(r.pose, NOISE, r.header('odom'))),
         'initialpose', "initialpose has frame_id 'odom', expected 'map'"),
    ],
)  # fmt: skip
def test_a_bad_message_is_refused_with_one_line(graph, send, name, words):
    robot = Robot(graph)
    robot.drive(0.3)
    robot.tick(0.1)
    send(robot)
    lines = robot.refusals(name)
    if words is None:
        assert lines == []  # a new message holds the identity quaternion
        return
    assert len(lines) == 1
    assert lines[0].startswith(words)
    assert '\n' not in lines[0]
    assert lines[0] in robot.report().message


def test_after_a_clock_jump_the_filter_restarts_and_warns_once(graph, capfd):
    robot = Robot(graph)
    robot.drive(1.0)
    robot.now -= 50.0
    robot.tick(0.0)
    robot.drive(1.0)
    assert capfd.readouterr().err.count('clock jumped') == 1
    assert robot.poses[-1].pose.position.x == pytest.approx(robot.pose.x, abs=0.02)


def test_what_comes_before_simulated_time_has_begun_is_refused_and_harms_nothing(graph):
    robot = Robot(graph, clock=False)
    robot.publish_a(ago=-1e9)
    assert robot.refusals('a') == ['simulated time has not started; publish /clock, or set use_sim_time to false']
    robot.tick(0.0)
    robot.drive(1.0)
    assert robot.poses[-1].pose.position.x == pytest.approx(robot.pose.x, abs=0.02)


def test_an_unknown_parameter_and_topics_without_a_publisher_are_logged_once(graph, capfd, monkeypatch):
    monkeypatch.setattr(input_watch, '_START_TIME', -1.0)
    node = graph.add(PoseArbiterNode, sources=['a', 'b'], wheel_radius=0.1)
    for _ in range(10):
        node._diagnostics.publish()
    words = capfd.readouterr().err
    assert words.count('parameter wheel_radius does not exist in this node and is ignored') == 1
    for topic in ('/a/pose_with_covariance (a)', '/b/pose_with_covariance (b)', '/odom (odom)'):
        assert words.count(f'{topic} has no publisher; check the topic name') == 1


@pytest.mark.parametrize(
    ('parameters', 'words'),
    [
        ({'sources': ['a', 'a']}, 'holds a twice; give each source a unique name'),
        ({'sources': ['a', 'b'], 'a.topic': '/p', 'b.topic': '/p'}, 'a and b have the same topic /p'),
        ({'sources': ['A b']}, "holds 'A b'; a name has lower-case letters"),
        ({'sources': ['class']}, "holds 'class'; a name has lower-case .* and is not a Python keyword"),
        ({'sources': ['rate']}, 'holds rate, which is a parameter'),
        ({'sources': ['odom']}, 'holds odom, which is reserved in the diagnostics'),
        ({'sources': ['a'], 'a.topic': 'b c'}, "setting a.topic is 'b c', which is not a valid topic name"),
        ({'sources': ['a'], 'a.topic': '/pose_arbiter/pose'}, 'a.topic is .* an output of this node'),
        ({'sources': 'a'}, 'must be a list of names'),
        ({'sources': [1.0]}, 'must be a list of names'),
        ({'sources': ['a'], 'a.sigma_xy': -1.0}, 'setting a.sigma_xy is -1.0 m, allowed is'),
        ({'sources': ['a'], 'a.offset': [1.0]}, 'setting a.offset is .* it must be 3 numbers'),
        ({'sources': ['a'], 'a.timout': 1.0}, 'parameter a.timout does not exist, did you mean a.timeout'),
        ({'gate_probability': 1.0}, 'setting gate_probability is 1.0'),
        *[({name: 'map'}, 'give each frame its own name') for name in ('odom_frame', 'base_frame')],
        ({'sources': ['a'], 'initialpose_for': 'b'}, "initialpose_for is 'b', it must be one of a"),
        ({'base_frame': 'odom'}, 'give each frame its own name'),
    ],
)
def test_bad_parameters_are_refused_with_one_line(graph, parameters, words):
    with pytest.raises(SettingsError, match=words) as refusal:
        graph.add(PoseArbiterNode, **parameters)
    assert '\n' not in str(refusal.value)


def test_a_bad_start_is_one_line_and_exit_code_1(capfd):
    assert run_in_process(main, '--ros-args', '-p', 'sources:=[floor, floor]') == 1
    (line,) = capfd.readouterr().err.splitlines()
    assert 'holds floor twice' in line
