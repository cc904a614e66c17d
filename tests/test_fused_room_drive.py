"""The poses and the odometry of a recorded drive through the arbiter: better than its source, and through an outage."""

import random
from pathlib import Path

import numpy as np
import pytest

from pose_arbiter.core.arbiter import Arbiter
from pose_arbiter.core.settings import ArbiterSettings, SourceSettings
from shirube_bags.bag_reader import BagReader
from shirube_bags.trajectory import can_interpolate, interpolate, planar_poses
from shirube_bags.trajectory_files import load_bag_trajectory
from shirube_core.geometry import SE2

BAG = Path(__file__).parents[1] / 'bags' / 'room_drive'
SOURCE = SourceSettings(sigma_xy=0.003, sigma_yaw=0.002)


def poses_of(bag, topic):
    recorded = load_bag_trajectory(bag, topic)
    poses = (SE2(*map(float, pose)) for pose in planar_poses(recorded))
    return list(zip(recorded.stamps_ns.tolist(), poses))


@pytest.fixture(scope='module')
def drive():
    with BagReader(BAG) as bag:
        return poses_of(bag, '/pose'), poses_of(bag, '/odom'), load_bag_trajectory(bag, '/ground_truth')


def fuse(source, odometry, wanted, shuffle=None):
    arbiter = Arbiter([SOURCE], ArbiterSettings(history_seconds=30.0))
    messages = sorted([(s, 0, p) for s, p in source] + [(s, 1, p) for s, p in odometry], key=lambda m: m[:2])
    now = messages[-1][0]
    if shuffle is not None:
        random.Random(shuffle).shuffle(messages)
    for stamp, kind, pose in messages:
        refusal = arbiter.add_odometry(stamp, pose, now) if kind else arbiter.add_pose(0, stamp, pose, None, now)
        assert refusal is None
    return [(s, SE2(e.x, e.y, e.yaw)) for s in wanted if (e := arbiter.estimate_at(s)) is not None]


def rms(values, truth):
    stamps = np.array([stamp for stamp, _ in values])
    known = can_interpolate(truth, stamps, 400_000_000)
    true = planar_poses(interpolate(truth, stamps[known]))
    poses = np.array([(p.x, p.y, p.yaw) for _, p in values])[known]
    turn = np.remainder(poses[:, 2] - true[:, 2] + np.pi, 2 * np.pi) - np.pi
    return np.sqrt(np.mean((poses - true)[:, :2] ** 2) * 2), np.sqrt(np.mean(turn**2))


def test_the_fused_pose_is_not_worse_than_its_source(drive):
    source, odometry, truth = drive
    ours = rms(fuse(source, odometry, [s for s, _ in source]), truth)
    assert (np.array(ours) <= 1.05 * np.array(rms(source, truth))).all()


def test_through_an_outage_it_is_better_than_odometry_alone(drive):
    source, odometry, truth = drive
    first, last = source[0][0], source[-1][0]
    begin, end = first + (last - first) * 2 // 5, first + (last - first) * 4 // 5
    silent = [s for s, _ in source if begin < s <= end]
    received = [pair for pair in source if not begin < pair[0] <= end]
    origin = source[0][1] @ odometry[0][1].inverse()
    alone = [(s, origin @ pose) for s, pose in odometry if begin < s <= end]
    ours = np.array(rms(fuse(received, odometry, silent), truth))
    assert (ours < rms(alone, truth)).all()


@pytest.mark.newest_set_only
def test_shuffled_arrival_gives_the_same(drive):
    source, odometry, _ = drive
    wanted = [s for s, _ in source[::20]]
    in_order = np.array([(p.x, p.y, p.yaw) for _, p in fuse(source, odometry, wanted)])
    shuffled = np.array([(p.x, p.y, p.yaw) for _, p in fuse(source, odometry, wanted, shuffle=1)])
    np.testing.assert_allclose(shuffled, in_order, atol=1e-9)
