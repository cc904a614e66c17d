"""Tests of map files, Nav2's depot among them."""

import os
from pathlib import Path

import cv2
import numpy as np
import pytest
import yaml

from reward_planner.core.occupancy_map import GridFrame, OccupancyMap
from reward_planner.core.reward_planner_error import RewardPlannerError
from reward_planner.files.occupancy_map_file import load_occupancy_map, save_occupancy_map

DEPOT = Path(os.environ.get('SHIRUBE_DATA', 'not given')) / 'planner' / 'depot.yaml'


@pytest.fixture
def saved(tmp_path: Path) -> Path:
    occupancy = np.random.default_rng(1).choice(np.array([-1, 0, 100], dtype=np.int8), (7, 11))
    path = tmp_path / 'map.yaml'
    save_occupancy_map(path, OccupancyMap(GridFrame(-1.5, 2.0, 0.05, 11, 7), occupancy))
    return path


def change(path: Path, **fields: object) -> None:
    content = {**yaml.safe_load(path.read_text()), **fields}
    path.write_text(yaml.safe_dump({name: value for name, value in content.items() if value is not None}))


def test_a_map_is_read_as_it_was_written(tmp_path: Path) -> None:
    occupancy = np.random.default_rng(2).choice(np.array([-1, 0, 100], dtype=np.int8), (30, 20))
    frame = GridFrame(-1.5, 2.0, 0.05, 20, 30)
    save_occupancy_map(tmp_path / 'map.yaml', OccupancyMap(frame, occupancy))
    again = load_occupancy_map(tmp_path / 'map.yaml')
    assert again.frame == frame
    np.testing.assert_array_equal(again.occupancy, occupancy)


def test_the_first_line_of_the_image_is_the_highest_row_and_dark_is_occupied(tmp_path: Path) -> None:
    (tmp_path / 'a.pgm').write_bytes(b'P5\n# made by hand\n2 2\n255\n' + bytes([0, 254, 205, 254]))
    fields = (
        'image: a.pgm\nresolution: 0.1\norigin: [0.0, 0.0, 0.0]\noccupied_thresh: 0.65\nfree_thresh: 0.196'
    )
    (tmp_path / 'a.yaml').write_text(fields)
    assert load_occupancy_map(tmp_path / 'a.yaml').occupancy.tolist() == [[-1, 0], [100, 0]]
    change(tmp_path / 'a.yaml', negate=1)
    assert load_occupancy_map(tmp_path / 'a.yaml').occupancy.tolist() == [[100, 100], [0, 100]]


def test_a_png_serves_as_well_as_a_pgm(saved: Path) -> None:
    before = load_occupancy_map(saved)
    image = cv2.imread(str(saved.with_suffix('.pgm')), cv2.IMREAD_GRAYSCALE)
    cv2.imwrite(str(saved.with_suffix('.png')), image)
    change(saved, image='map.png')
    np.testing.assert_array_equal(load_occupancy_map(saved).occupancy, before.occupancy)


@pytest.mark.skipif(not DEPOT.is_file(), reason='SHIRUBE_DATA names no planner/depot.yaml')
def test_the_depot_of_nav2_is_read() -> None:
    depot = load_occupancy_map(DEPOT, 0.05)
    assert depot.frame == GridFrame(0.0, 0.0, 0.05, 604, 307)
    assert set(np.unique(depot.occupancy)) <= {-1, 0, 100}
    assert 0.2 < (depot.occupancy == 0).mean() < 1.0


@pytest.mark.parametrize(
    ('fields', 'message'),
    [
        ({'resolution': None}, 'resolution is missing'),
        ({'resolution': -0.05}, 'resolution is -0.05'),
        ({'resolution': 'fine'}, "resolution is 'fine'"),
        ({'origin': [0.0, 0.0]}, 'origin is'),
        ({'origin': [0.0, float('nan'), 0.0]}, 'origin is'),
        ({'origin': [0.0, 0.0, 0.5]}, 'origin has a yaw'),
        ({'origin': [10**400, 0.0, 0.0]}, 'origin is'),
        ({'origin': [0.0, 1e308, 0.0]}, 'origin is'),
        ({'resolution': 10**400}, 'resolution is'),
        ({'mode': 'raw'}, 'mode'),
        ({'mode': ['x' * 1000] * 9}, 'mode'),
        ({'image': 'a\0b'}, 'image is'),
        ({'image': 'a' * 5000}, 'image is'),
        ({'image': ['map.pgm']}, 'image is'),
        ({'negate': 7}, 'negate'),
        ({'free_thresh': 0.9}, 'free_thresh'),
        ({'image': 'none.pgm'}, 'none.pgm: cannot be read'),
    ],
)
def test_a_wrong_field_is_named(saved: Path, fields: dict[str, object], message: str) -> None:
    change(saved, **fields)
    with pytest.raises(RewardPlannerError, match=message) as fault:
        load_occupancy_map(saved)
    assert '\n' not in str(fault.value)
    assert len(str(fault.value)) < len(str(saved)) + 200
    assert str(saved.parent) in str(fault.value)


def test_another_resolution_than_asked_is_refused(saved: Path) -> None:
    with pytest.raises(RewardPlannerError, match=r'0\.05 m, it must be 0\.1 m'):
        load_occupancy_map(saved, 0.1)


@pytest.mark.parametrize('change_of_length', [-5, 20])
def test_an_image_of_a_wrong_size_is_refused(saved: Path, change_of_length: int) -> None:
    image = saved.with_suffix('.pgm')
    data = image.read_bytes()
    image.write_bytes(data[:change_of_length] if change_of_length < 0 else data + bytes(change_of_length))
    with pytest.raises(RewardPlannerError, match='11 x 7 cells need 77'):
        load_occupancy_map(saved)


@pytest.mark.parametrize(
    'content', [b'', b'not an image', b'P5\n-3 4\n255\n', b'P5' + b'\n' * 60, b'P5' + b'\n#\n' * 40]
)
def test_what_is_no_image_is_refused(saved: Path, content: bytes) -> None:
    saved.with_suffix('.pgm').write_bytes(content)
    with pytest.raises(RewardPlannerError, match='not an image'):
        load_occupancy_map(saved)


def test_comments_may_be_between_all_numbers_of_the_header(saved: Path) -> None:
    before, image = load_occupancy_map(saved), saved.with_suffix('.pgm')
    cells = image.read_bytes()[-77:]
    image.write_bytes(b'P5 # by hand\n# wide\n11 # and high\n7\n# white\n255\n' + cells)
    np.testing.assert_array_equal(load_occupancy_map(saved).occupancy, before.occupancy)


@pytest.mark.parametrize('name', ['map.pgm', 'map', 'map.png', 'map.yaml.bak'])
def test_a_map_is_not_saved_under_another_ending(saved: Path, name: str) -> None:
    there = {path.name: path.read_bytes() for path in saved.parent.iterdir()}
    with pytest.raises(RewardPlannerError, match=f'{name}: is not a name for the YAML'):
        save_occupancy_map(saved.with_name(name), load_occupancy_map(saved))
    assert {path.name: path.read_bytes() for path in saved.parent.iterdir()} == there


@pytest.mark.parametrize('text', ['[', 'image', '\x00', '[' * 1000, 'image: &a [1]\nmode: *a'])
@pytest.mark.newest_set_only
def test_what_is_no_yaml_of_a_map_is_refused(tmp_path: Path, text: str) -> None:
    path = tmp_path / 'map.yaml'
    path.write_text(text)
    with pytest.raises(RewardPlannerError, match='map'):
        load_occupancy_map(path)
    with pytest.raises(RewardPlannerError, match='cannot be read'):
        load_occupancy_map(tmp_path / 'none.yaml')
