"""A bag of a drive through a room holds what the node needs, in order, with its truth, and comes out the same again."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from scene_simulator.commands import record_room_bag
from scene_simulator.room_bag import HEIGHTS, RESOLUTION, true_map
from scene_simulator.room_drive import RoomDrive
from shirube_bags.bag_reader import BagMessage, BagReader

SECONDS = 0.6


def record(path: Path, *options: object) -> int:
    return record_room_bag.main([str(a) for a in (path, '--seconds', SECONDS, *options)])


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
    cameras = {
        f'/{n}/{t}': 3 for n in ('left', 'right', 'top') for t in ('image_rect/compressed', 'camera_info')
    }
    assert counts == {**cameras, '/ground_truth': 3, '/pose': 12, '/odom': 30, '/truth/map': 1}


def test_every_message_is_received_at_its_stamp_and_in_order(bag: Path) -> None:
    messages = messages_in(bag)
    stamps = [message.stamp_ns for message in messages]
    assert stamps == sorted(stamps)
    with BagReader(bag) as reader:
        for message in messages:
            stamp = reader.decode(message).header.stamp
            assert stamp.sec * 1_000_000_000 + stamp.nanosec == message.stamp_ns


def test_the_true_map_is_what_a_point_by_point_look_says(bag: Path) -> None:
    scene = RoomDrive()
    with BagReader(bag) as reader:
        (grid,) = (reader.decode(m) for m in reader.messages(['/truth/map']))
    cells = grid.data.reshape(grid.info.height, grid.info.width)
    np.testing.assert_array_equal(cells, true_map(scene)[0])
    rng = np.random.default_rng(1)
    x0, y0, _, x1, y1, _ = scene.size
    points = rng.uniform((x0, y0), (x1, y1), (20_000, 2))
    solid = np.zeros(len(points), dtype=bool)
    for box in scene.room.boxes.boxes:
        if box[2] < HEIGHTS[1] and box[5] > HEIGHTS[0]:
            solid |= ((points > box[:2]) & (points < box[3:5])).all(axis=1)
    corner = (grid.info.origin.position.x, grid.info.origin.position.y)
    columns, rows = np.floor((points - corner) / RESOLUTION).astype(int).T
    assert (cells[rows, columns][solid] == 100).all()
    assert (cells[rows, columns][~solid] == 100).mean() < 0.06  # only cells at the edges


def test_the_same_seed_gives_the_same_bag_and_another_gives_another(bag: Path, tmp_path: Path) -> None:
    def contents(path: Path) -> list[tuple[str, int, bytes]]:
        return [
            (message.topic, message.stamp_ns, bytes(message.raw))
            for message in messages_in(path)
            if message.topic.endswith('compressed')
        ]

    assert record(tmp_path / 'again') == 0
    assert record(tmp_path / 'other', '--seed', 2) == 0
    assert contents(tmp_path / 'again') == contents(bag) != contents(tmp_path / 'other')


@pytest.mark.parametrize(
    ('options', 'words'),
    [
        (('--seed', -1), 'seed is -1'),
        (('--seconds', 0), 'positive number of seconds'),
        ((), 'exists already'),
    ],
)
def test_errors_are_one_line(
    options: tuple[object, ...], words: str, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    path = tmp_path if not options else tmp_path / 'bag'
    assert record(path, *options) == 1
    (line,) = [text for text in capsys.readouterr().err.splitlines() if 'record_room_bag:' in text]
    assert words in line
