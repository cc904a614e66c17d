"""The recorded mission through the arbiter, alone and as a live node: no worse than when it was recorded."""

import math
from pathlib import Path

import pytest
from geometry_msgs.msg import PoseStamped
from node_testing import isolated_graph, poses_in

from pose_arbiter.core.arbiter import Arbiter
from pose_arbiter.core.settings import ArbiterSettings, SourceSettings
from pose_arbiter.node import PoseArbiterNode
from shirube_bags.bag_reader import BagReader
from shirube_bags.commands.check import main as check
from shirube_bags.lockstep import replay_in_lockstep
from shirube_bags.trajectory import make_trajectory
from shirube_bags.trajectory_files import header_stamp, save_tum
from shirube_core.geometry import SE2, quaternion_from_yaw
from shirube_ros.message_conversion import planar_pose, planar_pose_with_covariance
from shirube_ros.quality_of_service import odometry_profile

BAG = Path(__file__).parents[1] / 'bags' / 'mission'
SOURCES = ('floor_localizer', 'stereo_landmark', 'vlc_beacon')
TOPICS = {f'/{name}/pose_with_covariance': number for number, name in enumerate(SOURCES)}
LIMITS = [
    *('--max-position-median', '0.003', '--max-position-rms', '0.005', '--max-position-max', '0.02'),
    *('--max-heading-rms', str(math.radians(0.5)), '--max-heading-max', str(math.radians(2.0))),
    *('--min-coverage', '0.95'),
]
"""Of the fused pose, wherever the robot is [m, rad, share]."""
AT_A_GOAL = 0.02
"""How far the fused pose may be off where the robot stands at the end [m]."""


def is_right(poses: dict[int, SE2], folder: Path) -> bool:
    """Return whether ``check`` finds the poses within the limits."""
    stamps = sorted(poses)
    places = [(poses[stamp].x, poses[stamp].y, 0.0) for stamp in stamps]
    turns = [quaternion_from_yaw(poses[stamp].yaw) for stamp in stamps]
    file = folder / 'fused.tum'
    save_tum(file, make_trajectory(stamps, places, turns))
    truth = ['--reference', str(BAG), '--reference-topic', '/ground_truth']
    return check([str(file), *truth, *LIMITS]) == 0


def fuse(bag: BagReader, shift: SE2 | None = None) -> dict[int, SE2]:
    """Return the arbiter's poses by stamp [ns]; with a shift, what the localizers say is off by it."""
    arbiter = Arbiter([SourceSettings()] * len(SOURCES), ArbiterSettings())
    poses = {}
    for message in bag.messages([*TOPICS, '/odom']):
        stamp = header_stamp(message.raw)
        decoded = bag.decode(message)
        if message.topic == '/odom':
            pose = planar_pose(decoded.pose.pose, message.topic)
            assert arbiter.add_odometry(stamp, pose, message.stamp_ns) is None
            estimate = arbiter.estimate_at(stamp)
            if estimate is not None:
                poses[stamp] = SE2(estimate.x, estimate.y, estimate.yaw)
            continue
        pose, covariance = planar_pose_with_covariance(decoded.pose, message.topic)
        measured = shift @ pose if shift else pose
        assert arbiter.add_pose(TOPICS[message.topic], stamp, measured, covariance, message.stamp_ns) is None
    return poses


def test_the_bag_holds_poses_odometry_grids_and_commands() -> None:
    with BagReader(BAG) as bag:
        counts = {name: topic.message_count for name, topic in bag.topics.items()}
        stamps = [message.stamp_ns for message in bag.messages(list(bag.topics))]
    assert stamps == sorted(stamps)
    assert counts['/goal_pose'] == 3
    for topic in (*TOPICS, '/cmd_vel', '/reward_planner/map', '/vlc_beacon/command'):
        assert counts[topic] > 0, topic
    for topic in ('/odom', '/pose_arbiter/pose', '/ground_truth'):
        assert counts[topic] > 0.95 * counts['/ground_truth'], topic


def test_the_mission_was_good_as_it_was_recorded(tmp_path: Path) -> None:
    with BagReader(BAG) as bag:
        assert is_right(poses_in(bag, '/pose_arbiter/pose'), tmp_path)


def test_the_arbiter_is_within_the_limits_and_right_at_the_last_goal(tmp_path: Path) -> None:
    with BagReader(BAG) as bag:
        poses, truths = fuse(bag), poses_in(bag, '/ground_truth')
    assert is_right(poses, tmp_path)
    last = max(poses.keys() & truths.keys())
    assert poses[last].distance_to(truths[last]) < AT_A_GOAL


@pytest.mark.parametrize('shift', [SE2(0.015, 0.0, 0.0), SE2(0.0, 0.0, math.radians(1.0))])
@pytest.mark.newest_set_only
def test_localizers_that_are_off_break_the_limits(shift: SE2, tmp_path: Path) -> None:
    with BagReader(BAG) as bag:
        assert not is_right(fuse(bag, shift), tmp_path)


@pytest.mark.timeout(600)
@pytest.mark.newest_set_only
def test_the_live_node_is_within_the_limits_too(tmp_path: Path) -> None:
    poses: dict[int, SE2] = {}

    def take(message: PoseStamped) -> None:
        stamp = message.header.stamp
        poses[stamp.sec * 1_000_000_000 + stamp.nanosec] = planar_pose(message.pose, 'pose')

    with isolated_graph() as graph, BagReader(BAG) as bag:
        graph.add(PoseArbiterNode, use_sim_time=True)
        player = graph.node('player')
        player.create_subscription(PoseStamped, '/pose_arbiter/pose', take, odometry_profile())
        assert replay_in_lockstep(bag, player, graph.executor, [*TOPICS, '/odom']) > 0
    assert is_right(poses, tmp_path)
