"""A bag of a stereo drive holds what the node needs, in order, with its truth, and comes out the same again."""

from __future__ import annotations

from pathlib import Path

import cv2
import numpy as np
import pytest

from scene_simulator.commands import record_stereo_bag
from scene_simulator.corridor_recordings import make_corridor_drive
from shirube_bags.bag_reader import BagMessage, BagReader

SECONDS = 0.4


def record(path: Path, *options: object) -> int:
    return record_stereo_bag.main([str(a) for a in (path, 'right', '--seconds', SECONDS, *options)])


@pytest.fixture(scope='module')
def bag(tmp_path_factory: pytest.TempPathFactory) -> Path:
    path = tmp_path_factory.mktemp('bags') / 'short'
    assert record(path) == 0
    return path


def messages_in(path: Path) -> list[BagMessage]:
    with BagReader(path) as reader:
        return list(reader.messages())


def test_the_bag_has_the_topics_at_their_rates(bag: Path) -> None:
    with BagReader(bag) as reader:
        counts = {name: topic.message_count for name, topic in reader.topics.items()}
    pictures = [
        f'/{side}/{name}' for side in ('left', 'right') for name in ('camera_info', 'image_rect/compressed')
    ]
    assert counts == {**dict.fromkeys([*pictures, '/ground_truth'], 2), '/odom': 20, '/imu': 20}


def test_every_message_is_received_at_its_stamp_and_in_order(bag: Path) -> None:
    messages = messages_in(bag)
    stamps = [message.stamp_ns for message in messages]
    assert stamps == sorted(stamps)
    with BagReader(bag) as reader:
        for message in messages:
            stamp = reader.decode(message).header.stamp
            assert stamp.sec * 1_000_000_000 + stamp.nanosec == message.stamp_ns


def test_truth_calibration_and_pictures_are_those_of_the_drive(bag: Path) -> None:
    with BagReader(bag) as reader:
        last = {message.topic: reader.decode(message) for message in reader.messages()}
    drive = make_corridor_drive('right')
    frame = list(drive.frames(SECONDS))[-1]
    truth = last['/ground_truth'].pose.position
    assert (truth.x, truth.y) == pytest.approx((frame.pose.x, frame.pose.y), abs=1e-9)
    projection = last['/right/camera_info'].p.reshape(3, 4)
    assert projection[0, 3] == pytest.approx(-projection[0, 0] * drive.rig.baseline)
    assert not last['/left/camera_info'].p.reshape(3, 4)[:, 3].any()
    for side, expected in (('left', frame.left), ('right', frame.right)):
        image = cv2.imdecode(last[f'/{side}/image_rect/compressed'].data, cv2.IMREAD_UNCHANGED)
        assert image.shape == expected.shape
        assert np.abs(image.astype(int) - expected).mean() < 2.0
        assert last[f'/{side}/camera_info'].header.frame_id == f'{side}_camera_optical_frame'


def test_a_raw_rig_records_raw_images_with_their_calibration(tmp_path: Path) -> None:
    assert record(tmp_path / 'raw', '--raw') == 0
    with BagReader(tmp_path / 'raw') as reader:
        assert '/left/image_raw/compressed' in reader.topics
        last = {message.topic: reader.decode(message) for message in reader.messages()}
    info = last['/right/camera_info']
    assert np.all(info.d != 0.0, where=[True, True, True, True, False])
    assert not np.allclose(info.r.reshape(3, 3), np.eye(3), atol=1e-3)


def test_the_same_seed_records_the_same_bag(bag: Path, tmp_path: Path) -> None:
    assert record(tmp_path / 'again') == 0
    assert messages_in(bag) == messages_in(tmp_path / 'again')


def test_a_bad_argument_ends_in_one_line(
    bag: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    for options, complaint in (
        ([str(bag), 'teach'], 'exists already'),
        ([str(tmp_path / 'b'), 'teach', '--seed', '-1'], 'seed'),
        ([str(tmp_path / 'b'), 'teach', '--seconds', '0'], 'positive number of seconds'),
    ):
        assert record_stereo_bag.main(options) == 1
        lines = capsys.readouterr().err.splitlines()
        assert len(lines) == 1
        assert complaint in lines[0]
