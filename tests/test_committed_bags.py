"""The committed bags are small and match the current scenes and drives of the simulator."""

from pathlib import Path

import cv2
import numpy as np
import pytest
from node_testing import poses_in

from scene_simulator.commands.floor import DIRTY_FRACTION
from scene_simulator.commands.recording import START_NS
from scene_simulator.corridor.stereo_drive import RUNS, SECONDS, StereoDrive, make_corridor_drive
from scene_simulator.corridor.stereo_rig import raw_rig
from scene_simulator.floor.demo_scene import DemoScene
from shirube_bags.bag_reader import BagReader

BAGS = Path(__file__).parents[1] / 'bags'
SCENE = DemoScene()
DRIVES = {f'corridor_{name}': (name, False) for name in RUNS} | {'corridor_raw': ('right', True)}


def drive_of(name: str) -> StereoDrive:
    run, is_raw = DRIVES[name]
    return make_corridor_drive(run, rig=raw_rig() if is_raw else None)


@pytest.mark.parametrize(
    ('names', 'most'), [('floor_drive', 10e6), ('corridor_*', 12e6), ('room_drive', 6e6), ('mission', 25e6)]
)
def test_the_bags_are_small(names: str, most: float) -> None:
    assert 0 < sum(file.stat().st_size for file in BAGS.glob(f'{names}/*')) < most


@pytest.mark.newest_set_only
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


def test_the_truth_of_the_bag_is_the_drive_of_the_scene() -> None:
    with BagReader(BAGS / 'floor_drive') as bag:
        for stamp, pose in poses_in(bag, '/ground_truth').items():
            true = SCENE.pose_at((stamp - START_NS) / 1e9)
            assert (pose.x, pose.y, pose.yaw) == pytest.approx((true.x, true.y, true.yaw))


def test_pictures_and_marks_of_the_bag_are_those_of_the_scene() -> None:
    with BagReader(BAGS / 'floor_drive') as bag:
        marks = {message.stamp_ns: bag.decode(message).data for message in bag.messages(['/dirt'])}
        for message in list(bag.messages(['/image_raw/compressed']))[::60]:
            image = cv2.imdecode(bag.decode(message).data, cv2.IMREAD_GRAYSCALE)
            time = (message.stamp_ns - START_NS) / 1e9
            rendered = SCENE.photograph(time, np.random.default_rng(1))
            assert np.abs(image.astype(int) - rendered.image).mean() < 4.0
            assert marks[message.stamp_ns] == (rendered.dirt_fraction > DIRTY_FRACTION)
    assert len(marks) == 600
    assert 20 < sum(marks.values()) < 60
