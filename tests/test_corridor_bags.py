"""The committed corridor bags match the simulator's current drives."""

from __future__ import annotations

import math
from pathlib import Path

import cv2
import numpy as np
import pytest

from scene_simulator.corridor.stereo_drive import RUNS, SECONDS, StereoDrive, make_corridor_drive
from scene_simulator.corridor.stereo_rig import raw_rig
from shirube_bags.bag_reader import BagReader
from shirube_core.geometry import yaw_from_quaternion

pytestmark = pytest.mark.newest_set_only

BAGS = Path(__file__).parents[1] / 'bags'
DRIVES = {f'corridor_{name}': (name, False) for name in RUNS} | {'corridor_raw': ('right', True)}


def drive_of(name: str) -> StereoDrive:
    run, is_raw = DRIVES[name]
    return make_corridor_drive(run, rig=raw_rig() if is_raw else None)


def test_the_bags_are_small() -> None:
    sizes = [file.stat().st_size for name in DRIVES for file in (BAGS / name).iterdir()]
    assert sum(sizes) < 12_000_000


@pytest.mark.parametrize('name', DRIVES)
def test_truth_and_pictures_of_a_bag_are_those_of_its_drive(name: str) -> None:
    drive, kind = drive_of(name), 'image_raw' if DRIVES[name][1] else 'image_rect'
    with BagReader(BAGS / name) as bag:
        truths = [bag.decode(message).pose for message in bag.messages(['/ground_truth'])]
        pictures = {
            side: bag.decode(next(iter(bag.messages([f'/{side}/{kind}/compressed'])))).data
            for side in ('left', 'right')
        }
    assert len(truths) == drive.frame_count(SECONDS) == 15
    for index, truth in enumerate(truths):
        pose, turn = drive.pose_at(index / drive.rate), truth.orientation
        yaw = yaw_from_quaternion(turn.x, turn.y, turn.z, turn.w)
        found = (truth.position.x, truth.position.y, yaw)
        assert found == pytest.approx((pose.x, pose.y, pose.yaw), abs=1e-9)
    first = next(iter(drive.frames(SECONDS)))
    for side, expected in (('left', first.left), ('right', first.right)):
        image = cv2.imdecode(pictures[side], cv2.IMREAD_GRAYSCALE)
        assert np.abs(image.astype(int) - expected).mean() < 2.0


def test_the_last_second_is_at_the_goal() -> None:
    for name, run in RUNS.items():
        with BagReader(BAGS / f'corridor_{name}') as bag:
            truths = [bag.decode(message).pose.position for message in bag.messages(['/ground_truth'])]
        for truth in truths[-3:]:
            assert math.hypot(truth.x - run.goal.x, truth.y - run.goal.y) < 1e-9
