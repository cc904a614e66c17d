"""The committed bag matches the simulator's current scene."""

from __future__ import annotations

from pathlib import Path

import cv2
import numpy as np
import pytest
from node_testing import poses_in

from scene_simulator.commands.floor import DIRTY_FRACTION
from scene_simulator.commands.recording import START_NS
from scene_simulator.floor.demo_scene import DemoScene
from shirube_bags.bag_reader import BagReader

BAG = Path(__file__).parents[1] / 'bags' / 'floor_drive'
SCENE = DemoScene()


def test_the_bag_is_small() -> None:
    assert sum(file.stat().st_size for file in BAG.iterdir()) < 10_000_000


def test_the_truth_of_the_bag_is_the_drive_of_the_scene() -> None:
    with BagReader(BAG) as bag:
        for stamp, pose in poses_in(bag, '/ground_truth').items():
            true = SCENE.pose_at((stamp - START_NS) / 1e9)
            assert (pose.x, pose.y, pose.yaw) == pytest.approx((true.x, true.y, true.yaw))


def test_pictures_and_marks_of_the_bag_are_those_of_the_scene() -> None:
    with BagReader(BAG) as bag:
        marks = {message.stamp_ns: bag.decode(message).data for message in bag.messages(['/dirt'])}
        for message in list(bag.messages(['/image_raw/compressed']))[::60]:
            image = cv2.imdecode(bag.decode(message).data, cv2.IMREAD_GRAYSCALE)
            time = (message.stamp_ns - START_NS) / 1e9
            rendered = SCENE.photograph(time, np.random.default_rng(1))
            assert np.abs(image.astype(int) - rendered.image).mean() < 4.0
            assert marks[message.stamp_ns] == (rendered.dirt_fraction > DIRTY_FRACTION)
    assert len(marks) == 600
    assert 20 < sum(marks.values()) < 60
