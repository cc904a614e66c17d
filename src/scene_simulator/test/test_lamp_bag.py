"""A bag of a drive under lamps holds what the node needs, in order, with its truth, and comes out the same again."""

from __future__ import annotations

import math
from pathlib import Path

import cv2
import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from scene_simulator.commands import record_lamp_bag
from scene_simulator.paper_run import paper_run
from shirube_bags.bag_reader import BagMessage, BagReader
from shirube_core.waveform import steady_light, waveform_from_steps, waveform_to_csv

SECONDS = 0.2


@pytest.fixture(scope='module')
def waveforms(tmp_path_factory: pytest.TempPathFactory) -> list[str]:
    """Files of three lamps that shine and of one whose halves never shine together."""
    folder = tmp_path_factory.mktemp('waveforms')
    halves = waveform_from_steps([0.004, 0.004], [[1.0, 0.0], [0.0, 1.0]])
    for beacon in range(11, 15):
        light = halves if beacon == 14 else steady_light(2)
        (folder / f'{beacon}.csv').write_text(waveform_to_csv(light))
    return [f'{beacon}={folder / f"{beacon}.csv"}' for beacon in range(11, 15)]


def record(path: Path, waveforms: list[str], *options: object) -> int:
    return record_lamp_bag.main([str(a) for a in (path, *waveforms, '--seconds', SECONDS, *options)])


@pytest.fixture(scope='module')
def bag(tmp_path_factory: pytest.TempPathFactory, waveforms: list[str]) -> Path:
    path = tmp_path_factory.mktemp('bags') / 'short'
    assert record(path, waveforms) == 0
    return path


def messages_in(path: Path) -> list[BagMessage]:
    with BagReader(path) as reader:
        return list(reader.messages())


def test_the_bag_has_the_topics_at_their_rates(bag: Path) -> None:
    with BagReader(bag) as reader:
        counts = {name: topic.message_count for name, topic in reader.topics.items()}
    frames = math.ceil(SECONDS * 60.0 * record_lamp_bag.CLOCK_RATIO)
    pictures = dict.fromkeys(('/image_raw/compressed', '/camera_info', '/ground_truth'), frames)
    assert counts == {**pictures, '/odom': 10, '/imu': 10}


def test_every_message_is_received_at_its_stamp_and_in_order(bag: Path) -> None:
    messages = messages_in(bag)
    stamps = [message.stamp_ns for message in messages]
    assert stamps == sorted(stamps)
    with BagReader(bag) as reader:
        for message in messages:
            stamp = reader.decode(message).header.stamp
            assert stamp.sec * 1_000_000_000 + stamp.nanosec == message.stamp_ns


def test_truth_calibration_tilt_and_picture_are_the_drive(bag: Path) -> None:
    with BagReader(bag) as reader:
        last = {message.topic: reader.decode(message) for message in reader.messages()}
    drive = paper_run([steady_light(2)] * 4, camera=record_lamp_bag.GLOBAL, rest=record_lamp_bag.REST)
    pose = drive.pose_at(SECONDS)
    truth = last['/ground_truth'].pose.position
    assert (truth.x, truth.y) == pytest.approx((pose.x, pose.y), abs=1e-6)
    np.testing.assert_array_equal(
        last['/camera_info'].k.reshape(3, 3), record_lamp_bag.GLOBAL.intrinsics.matrix
    )
    turn = last['/imu'].orientation
    roll, pitch, _ = Rotation.from_quat([turn.x, turn.y, turn.z, turn.w]).as_euler('xyz')
    assert (roll, pitch) == pytest.approx(drive.tilt_at(0.18), abs=math.radians(0.5))
    image = cv2.imdecode(last['/image_raw/compressed'].data, cv2.IMREAD_UNCHANGED)
    frame = list(drive.frames(SECONDS))[-1]
    assert image.shape == frame.photo.image.shape
    lamp_b = next(s for s in frame.photo.lamp_projections if s.lamp == 2)
    u, v = (round(x) for x in lamp_b.centre)
    around = np.s_[v - 6 : v + 7, u - 6 : u + 7]
    assert np.abs(image[around].astype(int) - frame.photo.image[around]).mean() < 6.0


def test_a_rolling_shutter_sees_stripes_at_thirty_images_a_second(
    waveforms: list[str], tmp_path: Path
) -> None:
    assert record(tmp_path / 'rolling', waveforms, '--shutter', 'rolling') == 0
    with BagReader(tmp_path / 'rolling') as reader:
        assert reader.topics['/image_raw/compressed'].message_count == math.ceil(
            SECONDS * 30.0 * record_lamp_bag.CLOCK_RATIO
        )
        last = {message.topic: reader.decode(message) for message in reader.messages()}
    image = cv2.imdecode(last['/image_raw/compressed'].data, cv2.IMREAD_UNCHANGED)
    assert image.shape == (1024, 1280)


def test_the_beacons_file_is_written_with_the_bag(bag: Path) -> None:
    lines = (bag / 'beacons.yaml').read_text().splitlines()
    assert lines[0] == 'beacons:'
    assert lines[4] == '  - {id: 14, xyz: [1.8, 1.8, 2.5], radius: 0.0325}'
    assert len(lines) == 5


def test_the_same_seed_records_the_same_bag(bag: Path, waveforms: list[str], tmp_path: Path) -> None:
    assert record(tmp_path / 'again', waveforms) == 0
    assert messages_in(bag) == messages_in(tmp_path / 'again')


def test_a_bad_argument_ends_in_one_line(
    waveforms: list[str], tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    (tmp_path / 'no.csv').write_text('x,y\n')
    bad = {
        'give each lamp': ['lamp.csv', *waveforms[1:]],
        'unique ID': [waveforms[1], *waveforms[1:]],
        'cannot be read': [f'1={tmp_path / "none.csv"}', *waveforms[1:]],
        'first line': [f'1={tmp_path / "no.csv"}', *waveforms[1:]],
        '4 waveforms': waveforms[1:],
    }
    for complaint, lamps in bad.items():
        assert record(tmp_path / 'bag', lamps) == 1
        lines = capsys.readouterr().err.splitlines()
        assert len(lines) == 1
        assert complaint in lines[0]
    assert record(tmp_path, waveforms) == 1
    assert 'exists already' in capsys.readouterr().err
    assert record(tmp_path / 'bag', waveforms, '--seed', -1) == 1
    assert 'seed' in capsys.readouterr().err
