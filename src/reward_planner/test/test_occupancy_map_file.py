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

DATA = Path(os.environ.get('SHIRUBE_DATA', 'not given'))
DEPOT = DATA / 'planner' / 'depot.yaml'
NAV2_MAPS = DATA / 'planner_nav2_maps'


def write_map(folder: Path, pixels: object, suffix: str = '.png', **fields: object) -> Path:
    """Write an image, first line first, and its YAML file."""
    cv2.imwrite(str(folder / f'a{suffix}'), np.array(pixels, dtype=np.uint8))
    standard = {'image': f'a{suffix}', 'resolution': 0.1, 'origin': [0.0, 0.0, 0.0], 'negate': 0}
    path = folder / 'a.yaml'
    path.write_text(yaml.safe_dump({**standard, 'occupied_thresh': 0.65, 'free_thresh': 0.25, **fields}))
    return path


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
    fields = 'image: a.pgm\nresolution: 0.1\norigin: [0.0, 0.0, 0.0]\noccupied_thresh: 0.65\nfree_thresh: 0.196'
    (tmp_path / 'a.yaml').write_text(fields)
    assert load_occupancy_map(tmp_path / 'a.yaml').occupancy.tolist() == [[-1, 0], [100, 0]]
    change(tmp_path / 'a.yaml', negate=1)
    assert load_occupancy_map(tmp_path / 'a.yaml').occupancy.tolist() == [[100, 100], [0, 100]]


@pytest.mark.parametrize('suffix', ['.png', '.bmp'])
@pytest.mark.parametrize('channels', [cv2.COLOR_GRAY2BGR, cv2.COLOR_GRAY2BGRA])
def test_other_images_serve_as_well_as_a_pgm(saved: Path, suffix: str, channels: int) -> None:
    before = load_occupancy_map(saved)
    image = cv2.imread(str(saved.with_suffix('.pgm')), cv2.IMREAD_GRAYSCALE)
    cv2.imwrite(str(saved.with_suffix(suffix)), cv2.cvtColor(image, channels))
    change(saved, image=f'map{suffix}')
    np.testing.assert_array_equal(load_occupancy_map(saved).occupancy, before.occupancy)


@pytest.mark.parametrize(
    ('fields', 'cells'),
    [
        ({}, [100, 100, -1, 0, 0]),
        ({'negate': 1}, [0, -1, -1, 100, 100]),
        ({'mode': 'scale'}, [100, 100, 62, 0, 0]),
        ({'mode': 'scale', 'occupied_thresh': 1.0, 'free_thresh': 0.0}, [100, 70, 50, 20, 0]),
        ({'mode': 'scale', 'occupied_thresh': 0.4, 'free_thresh': 0.4}, [100, 100, 100, 0, 0]),
        ({'mode': 'raw'}, [0, 77, -1, -1, -1]),
        # A value at a threshold belongs to it, as in Jazzy; 0.2 is 51 / 255, with and without rounding.
        ({'occupied_thresh': 1.0, 'free_thresh': 0.0}, [100, -1, -1, -1, 0]),
        ({'negate': 1, 'occupied_thresh': 0.8, 'free_thresh': 0.0}, [0, -1, -1, 100, 100]),
    ],
)
def test_grey_values_become_cells_as_in_nav2(tmp_path: Path, fields: dict, cells: list[int]) -> None:
    path = write_map(tmp_path, [[0, 77, 128, 204, 255]], '.pgm', **fields)
    assert load_occupancy_map(path).occupancy.tolist() == [cells]


@pytest.mark.parametrize(('mode', 'cells'), [('trinary', [0, -1, -1]), ('scale', [0, -1, -1]), ('raw', [-1, 0, 50])])
def test_pixels_that_are_not_opaque_are_unknown(tmp_path: Path, mode: str, cells: list[int]) -> None:
    pixels = [[[255, 255, 255, 255], [0, 0, 0, 0], [50, 50, 50, 254]]]
    assert load_occupancy_map(write_map(tmp_path, pixels, mode=mode)).occupancy.tolist() == [cells]


@pytest.mark.parametrize('yaw', [1.0, -2.5, np.pi / 2, np.pi])
def test_a_turned_map_has_its_cells_where_they_are(tmp_path: Path, yaw: float) -> None:
    rng = np.random.default_rng(3)
    pixels = np.where(rng.random((20, 30)) < 0.2, 0, 254)
    path = write_map(tmp_path, pixels, '.pgm', origin=[2.0, 3.0, yaw])
    turned = load_occupancy_map(path)
    centres = 0.1 * (np.argwhere(pixels[::-1] == 0)[:, ::-1] + 0.5)
    turn = np.array([[np.cos(yaw), -np.sin(yaw)], [np.sin(yaw), np.cos(yaw)]])
    rows, columns = turned.frame.cell_of(centres @ turn.T + (2.0, 3.0)).T
    assert (turned.occupancy[rows, columns] == 100).all()
    places = turned.frame.centre_of(np.argwhere(turned.occupancy == 100))
    gaps = np.linalg.norm(places[:, None] - (centres @ turn.T + (2.0, 3.0)), axis=2).min(axis=1)
    assert gaps.max() <= 0.1 * np.sqrt(0.5) + 1e-9
    assert (turned.occupancy >= 0).sum() == pytest.approx(pixels.size, rel=0.05)


def test_scaled_values_are_saved_and_read_back(tmp_path: Path) -> None:
    cells = np.arange(-1, 101, dtype=np.int8).reshape(6, 17)
    frame = GridFrame(-1.5, 2.0, 0.05, 17, 6)
    save_occupancy_map(tmp_path / 'map.yaml', OccupancyMap(frame, cells))
    again = load_occupancy_map(tmp_path / 'map.yaml')
    assert again.frame == frame
    np.testing.assert_array_equal(again.occupancy, cells)


@pytest.mark.skipif(not NAV2_MAPS.is_dir(), reason='SHIRUBE_DATA names no planner_nav2_maps')
@pytest.mark.parametrize(
    ('name', 'values'),
    [
        ('depot_keepout', [-1, 0, 100]),
        ('depot_speed', [0, 20, 25, 50, 100]),
        ('keepout_mask', [-1, 0, 100]),
        ('speed_mask', [0, 19, 50]),
        ('tb3_sandbox', [-1, 0, 100]),
        ('testmap', [-1, 0, 100]),
    ],
)
def test_maps_and_masks_of_nav2_are_read_and_saved(name: str, values: list[int], tmp_path: Path) -> None:
    read = load_occupancy_map(NAV2_MAPS / f'{name}.yaml')
    assert set(np.unique(read.occupancy)) <= set(values)
    save_occupancy_map(tmp_path / 'map.yaml', read)
    again = load_occupancy_map(tmp_path / 'map.yaml')
    assert again.frame == read.frame
    np.testing.assert_array_equal(again.occupancy, read.occupancy)


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
        *(({'origin': place}, 'origin is') for place in ([0.0, 0.0], [0.0, 1e308, 0.0], [10**400, 0.0, 0.0])),
        *(({'origin': place}, 'origin is') for place in ([0.0, float('nan'), 0.0], [0.0, 0.0, 'north'])),
        ({'resolution': 10**400}, 'resolution is'),
        ({'mode': 'grey'}, 'mode is .*trinary, scale or raw'),
        ({'mode': ['x' * 1000] * 9}, 'mode'),
        *(({'image': image}, 'image is') for image in ('a\0b', 'a' * 5000, ['map.pgm'])),
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
