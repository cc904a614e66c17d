"""The committed corridor bags match the simulator's current drives."""

from __future__ import annotations

from pathlib import Path

import cv2
import numpy as np
import pytest
from node_testing import poses_in

from scene_simulator.corridor.stereo_drive import RUNS, SECONDS, StereoDrive, make_corridor_drive
from scene_simulator.corridor.stereo_rig import raw_rig
from shirube_bags.bag_reader import BagReader

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
        truths = list(poses_in(bag, '/ground_truth').values())
        firsts = [next(bag.messages([f'/{side}/{kind}/compressed'])) for side in ('left', 'right')]
        pictures = [cv2.imdecode(bag.decode(message).data, cv2.IMREAD_GRAYSCALE) for message in firsts]
    assert len(truths) == drive.frame_count(SECONDS) == 15
    for index, truth in enumerate(truths):
        pose = drive.pose_at(index / drive.rate)
        assert (truth.x, truth.y, truth.yaw) == pytest.approx((pose.x, pose.y, pose.yaw), abs=1e-9)
    first = next(iter(drive.frames(SECONDS)))
    for image, expected in zip(pictures, (first.left, first.right), strict=True):
        assert np.abs(image.astype(int) - expected).mean() < 2.0
