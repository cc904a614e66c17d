"""The commands that write maps and pictures end with a file, or with one line and exit code 1."""

import csv
from collections.abc import Callable
from pathlib import Path

import cv2
import numpy as np
import pytest
import yaml

from scene_simulator.commands.corridor import render_stereo_pair
from scene_simulator.commands.floor import generate_floor, write_dot_map
from scene_simulator.corridor.generator import CorridorDesign, corridor


def test_a_map_is_written_to_the_micrometre(tmp_path: Path) -> None:
    path = tmp_path / 'generated.csv'
    assert generate_floor([str(path), '--size', '0.5', '0.4', '--count', '1000', '--seed', '3']) == 0
    assert len(path.read_text().splitlines()) == 1001
    dots, path = np.random.default_rng(1).uniform(0.0, 9.0, (30, 3)), tmp_path / 'deep' / 'floor.csv'
    write_dot_map(dots, path)
    assert path.read_text().startswith('x,y,diameter\n')
    np.testing.assert_allclose(np.loadtxt(path, delimiter=',', skiprows=1), dots, atol=0.51e-6)
    assert list(path.parent.iterdir()) == [path]


@pytest.mark.newest_set_only
def test_render_stereo_pair_writes_pictures_calibration_and_truth(tmp_path: Path) -> None:
    folder = tmp_path / 'new' / 'pair'
    assert render_stereo_pair([str(folder), '--seed', '3', '--pose', '-3.2', '0.1', '0.05', '--raw']) == 0
    for side in ('left', 'right'):
        assert cv2.imread(str(folder / f'{side}.png'), cv2.IMREAD_UNCHANGED).shape == (480, 752)
        assert yaml.safe_load((folder / f'{side}.yaml').read_text())['camera_name'] == side
    with (folder / 'points.csv').open() as file:
        rows = {row['name']: (row['x'], row['y'], row['z']) for row in csv.DictReader(file)}
    expected = corridor(CorridorDesign(3)).points_map()
    assert rows.keys() == expected.keys()
    np.testing.assert_allclose(np.array(rows['cabinet/2'], float), expected['cabinet/2'], atol=1e-6)


@pytest.mark.parametrize(
    ('main', 'arguments', 'complaint'),
    [
        (generate_floor, '{file}/floor.csv --count 10', 'choose a writable place'),
        (generate_floor, '{tmp}/floor.csv --size 0.01 0.01', 'do not fit'),
        (render_stereo_pair, '{file}/pair', 'choose a writable place'),
        (render_stereo_pair, '{tmp}/pair --seed -1', 'seed'),
        (render_stereo_pair, '{tmp}/pair --people -1', 'people'),
    ],
)
def test_a_bad_argument_ends_in_one_line(
    tmp_path: Path, capfd: pytest.CaptureFixture[str], main: Callable[[list[str]], int], arguments: str, complaint: str
) -> None:
    (tmp_path / 'file').write_text('')
    assert main(arguments.format(tmp=tmp_path, file=tmp_path / 'file').split()) == 1
    lines = [line for line in capfd.readouterr().err.splitlines() if line.strip()]
    assert len(lines) == 1
    assert complaint in lines[0]
