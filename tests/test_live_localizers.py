"""Excerpts of the recorded lamp and corridor bags through the live nodes: poses and commands as documented."""

from __future__ import annotations

import json
import os
import shutil
import subprocess
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from geometry_msgs.msg import PoseStamped
from node_testing import isolated_graph, poses_in
from std_msgs.msg import String

from shirube_bags.bag_reader import BagReader
from shirube_bags.bag_writer import BagWriter
from shirube_bags.lockstep import replay_in_lockstep
from shirube_core.geometry import SE2
from shirube_ros.pose_conversion import planar_pose
from shirube_ros.quality_of_service import pose_profile
from stereo_landmark.commands.teach import main as teach
from stereo_landmark.node import StereoLandmarkNode
from vlc_beacon.core.packet.command_packet import Operation
from vlc_beacon.files.counter_file import CounterFile
from vlc_beacon.node import VlcBeaconNode

pytestmark = [pytest.mark.newest_set_only, pytest.mark.timeout(600)]

BAGS = Path(__file__).parents[1] / 'bags'


def excerpt(source: Path, path: Path, seconds: float, keep: Callable[[float], bool] = lambda _: True) -> Path:
    """Copy the messages of the first seconds of a bag at times that are kept [s]."""
    with BagReader(source) as bag, BagWriter(path) as copy:
        for raw in bag.messages():
            time = 1e-9 * (raw.stamp_ns - bag.start_ns)
            if time > seconds:
                break
            if keep(time):
                copy.write_raw(raw.topic, raw.msgtype, raw.raw, raw.stamp_ns)
    return path


def replay_live(
    node_class: type, bag: Path, **parameters: Any
) -> tuple[dict[int, SE2], dict[int, SE2], list[dict[str, Any]]]:
    """Return the node's poses and the true ones by stamp [ns], and the commands that it accepted."""
    poses: dict[int, SE2] = {}
    commands: list[dict[str, Any]] = []

    def take_pose(message: PoseStamped) -> None:
        stamp = message.header.stamp
        poses[stamp.sec * 1_000_000_000 + stamp.nanosec] = planar_pose(message.pose, 'pose')

    with isolated_graph() as graph, BagReader(bag) as reader:
        node = graph.add(node_class, use_sim_time=True, image_transport='compressed', **parameters)
        player, name = graph.node('player'), node.get_fully_qualified_name()
        player.create_subscription(PoseStamped, f'{name}/pose', take_pose, pose_profile())
        player.create_subscription(
            String, f'{name}/command', lambda m: commands.append(json.loads(m.data)), pose_profile()
        )
        topics = [topic for topic in reader.topics if topic != '/ground_truth']
        assert replay_in_lockstep(reader, player, graph.executor, topics) > 0
        graph.spin_until(lambda: False, timeout=0.2)
        return poses, poses_in(reader, '/ground_truth'), commands


def errors(poses: dict[int, SE2], truth: dict[int, SE2]) -> np.ndarray:
    """Return the errors of position [m]; a pose of another stamp is a KeyError."""
    return np.array([pose.distance_to(truth[stamp]) for stamp, pose in poses.items()])


def test_the_lamps_of_the_bag_locate_the_live_node_and_command_it(tmp_path: Path) -> None:
    bag = BAGS / 'lamp_drive'
    shutil.copy(bag / 'demo_key', tmp_path / 'key')
    (tmp_path / 'key').chmod(0o600)
    CounterFile(tmp_path / 'counters.json').reset(0)
    # All images while the lamps are read; then a few, for the pose, until the robot is under lamp 4.
    beginning = excerpt(bag, tmp_path / 'bag', 12.6, lambda time: time < 6.5 or time % 0.25 < 0.03)
    poses, truth, commands = replay_live(
        VlcBeaconNode,
        beginning,
        beacons_file=str(bag / 'beacons.yaml'),
        camera_xyz=[0.0, 0.0, 0.0],
        key_file=str(tmp_path / 'key'),
        counter_file=str(tmp_path / 'counters.json'),
    )
    assert len(poses) > 0.5 * len(truth)
    assert np.median(errors(poses, truth)) < 0.004
    assert errors(poses, truth).max() < 0.025
    assert [(c['beacon'], c['op']) for c in commands] == [
        (4, Operation.SLOW.label),
        (4, Operation.TURN.label),
    ]


def test_a_rolling_shutter_locates_the_live_node(tmp_path: Path) -> None:
    bag = BAGS / 'lamp_drive_rolling'
    poses, truth, commands = replay_live(
        VlcBeaconNode,
        excerpt(bag, tmp_path / 'bag', 4.5),
        beacons_file=str(bag / 'beacons.yaml'),
        camera_xyz=[0.0, 0.0, 0.0],
        shutter='rolling',
        exposure_time=60e-6,
    )
    assert len(poses) > 30
    assert np.median(errors(poses, truth)) < 0.004
    assert errors(poses, truth).max() < 0.02
    assert commands == []


def test_the_taught_place_locates_the_live_node_in_the_corridor(tmp_path: Path) -> None:
    assert (
        teach(['--batch', str(BAGS / 'corridor_teach/lesson.yaml'), '--places', str(tmp_path / 'places')])
        == 0
    )
    bag = excerpt(BAGS / 'corridor_left', tmp_path / 'bag', 3.0)
    mount = {'camera_xyz': [0.1, 0.12, 1.25]}
    poses, truth, _ = replay_live(StereoLandmarkNode, bag, places_dir=str(tmp_path / 'places'), **mount)
    assert len(poses) > 0.5 * len(truth)
    assert np.median(errors(poses, truth)) < 0.002
    assert errors(poses, truth).max() < 0.006


def test_ros2_run_starts_the_installed_programs() -> None:
    ros2 = shutil.which('ros2')
    if ros2 is None:
        pytest.skip('no ROS installation: ros2 is not on the PATH')
    known = subprocess.run([ros2, 'pkg', 'prefix', 'vlc_beacon'], capture_output=True, text=True, check=False)
    if known.returncode != 0:
        pytest.skip('the workspace is not built or sourced: colcon build, then . install/setup.bash')
    command = [ros2, 'run', 'vlc_beacon', 'locate', '--help']
    done = subprocess.run(command, capture_output=True, text=True, check=False, env=os.environ)
    assert done.returncode == 0, done.stderr
    assert '--beacons' in done.stdout
