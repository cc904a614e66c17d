"""A recorded bag holds what the node needs, in order, with its truth, and comes out the same again."""

from __future__ import annotations

import math
from pathlib import Path

import cv2
import numpy as np
import pytest

from scene_simulator.demo_scene import DEMO_CAMERA, DemoScene
from scene_simulator.errors import SceneError
from scene_simulator.floor_bag import START_NS, image_count, record_drive
from shirube_bags.bag_reader import BagMessage, BagReader
from shirube_bags.errors import BagError
from shirube_core.geometry import yaw_from_quaternion

SCENE = DemoScene()


@pytest.fixture(scope='module')
def bag(tmp_path_factory: pytest.TempPathFactory) -> Path:
    path = tmp_path_factory.mktemp('bags') / 'short'
    assert list(record_drive(SCENE, path, 1.0)) == list(range(10))
    return path


def messages_in(path: Path) -> list[BagMessage]:
    with BagReader(path) as reader:
        return list(reader.messages())


def test_the_bag_has_the_topics_at_their_rates(bag: Path) -> None:
    with BagReader(bag) as reader:
        counts = {name: topic.message_count for name, topic in reader.topics.items()}
    pictures = dict.fromkeys(('/image_raw/compressed', '/camera_info', '/ground_truth', '/dirt'), 10)
    assert counts == {**pictures, '/odom': 50}
    assert image_count(60.0) == 600


def test_every_message_is_received_at_its_stamp_and_in_order(bag: Path) -> None:
    messages = messages_in(bag)
    stamps = [message.stamp_ns for message in messages]
    assert stamps == sorted(stamps)
    assert stamps[0] == START_NS
    with BagReader(bag) as reader:
        for message in messages:
            content = reader.decode(message)
            if message.topic != '/dirt':
                stamp = content.header.stamp
                assert stamp.sec * 1_000_000_000 + stamp.nanosec == message.stamp_ns


def test_truth_calibration_and_picture_are_the_scene(bag: Path) -> None:
    with BagReader(bag) as reader:
        last = {message.topic: reader.decode(message) for message in reader.messages()}
    pose, true = last['/ground_truth'].pose, SCENE.pose_at(0.9)
    assert (pose.position.x, pose.position.y, pose.position.z) == (true.x, true.y, 0.0)
    turn = pose.orientation
    assert yaw_from_quaternion(turn.x, turn.y, turn.z, turn.w) == pytest.approx(true.yaw)
    np.testing.assert_array_equal(last['/camera_info'].k.reshape(3, 3), DEMO_CAMERA.matrix)
    np.testing.assert_array_equal(last['/camera_info'].d, DEMO_CAMERA.distortion)
    image = cv2.imdecode(last['/image_raw/compressed'].data, cv2.IMREAD_UNCHANGED)
    clean = SCENE.photograph(0.9, np.random.default_rng(5)).image
    assert image.shape == (235, 235)
    assert np.abs(image.astype(int) - clean).mean() < 4.0
    assert last['/dirt'].data is False or not last['/dirt'].data


def test_the_odometry_starts_at_zero_and_follows_the_drive(bag: Path) -> None:
    with BagReader(bag) as reader:
        odometry = [reader.decode(message) for message in reader.messages(['/odom'])]
    first, last = odometry[0].pose.pose, odometry[-1].pose.pose
    assert (first.position.x, first.position.y, first.orientation.w) == (0.0, 0.0, 1.0)
    way = math.hypot(last.position.x, last.position.y)
    assert way == pytest.approx(SCENE.pose_at(0.0).distance_to(SCENE.pose_at(0.98)), rel=0.05)
    assert odometry[-1].twist.twist.linear.x == pytest.approx(0.25, abs=0.03)


def test_the_same_seed_records_the_same_bag(bag: Path, tmp_path: Path) -> None:
    for _ in record_drive(DemoScene(), tmp_path / 'again', 1.0):
        pass
    assert messages_in(bag) == messages_in(tmp_path / 'again')


def test_a_bag_is_never_overwritten(bag: Path) -> None:
    with pytest.raises(BagError, match='exists'):
        next(record_drive(SCENE, bag, 1.0))


@pytest.mark.parametrize('seconds', [0.0, -1.0, math.nan, math.inf])
def test_an_impossible_length_is_refused(seconds: float, tmp_path: Path) -> None:
    with pytest.raises(SceneError, match='recording'):
        next(record_drive(SCENE, tmp_path / 'none', seconds))
