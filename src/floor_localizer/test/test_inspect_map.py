from pathlib import Path

import cv2
import numpy as np
import pytest
from dot_maps import random_map

from floor_localizer.commands.inspect_map import main
from floor_localizer.core.dots import DotMap
from floor_localizer.files.dot_map_file import load_dot_map, save_csv


@pytest.fixture
def floor(tmp_path: Path) -> Path:
    patch, other = (random_map(seed, (0.3, 0.2)).points for seed in (1, 2))
    points = np.vstack([patch, np.add(patch, (0.5, 0.0)), np.add(other, (1.0, 0.0))])
    save_csv(tmp_path / 'floor.csv', DotMap(points, np.full(len(points), np.nan)))
    return tmp_path / 'floor.csv'


def test_the_report_lists_the_unique_and_the_ambiguous_places(floor, run):
    code, out, _ = run(main, floor)
    assert code == 0
    assert f'{len(load_dot_map(floor))}\n' in out
    lines = out.splitlines()
    ambiguous = [k for k, line in enumerate(lines) if 'ambiguous with another place' in line]
    assert ambiguous
    assert '100% match at' in lines[ambiguous[0] + 1]
    assert 'mirror' not in out


def test_the_binary_map_that_it_writes_gives_the_same_report(floor, tmp_path, run):
    _, first, _ = run(main, floor, '--write', tmp_path / 'out' / 'floor.dotmap')
    code, second, _ = run(main, tmp_path / 'out' / 'floor.dotmap')
    assert code == 0
    assert second.splitlines()[1:] == first.splitlines()[1:]


def test_the_picture_marks_the_ambiguous_places_in_red(floor, tmp_path, run):
    run(main, floor, '--picture', tmp_path / 'floor.png')
    picture = cv2.imread(str(tmp_path / 'floor.png')).astype(int)
    blue, green, red = (picture[:, :, k] for k in range(3))
    columns = np.nonzero((red > 180) & (green < 90) & (blue < 90))[1]
    assert len(columns) > 50
    # The copies are the left two thirds of the floor.
    assert np.quantile(columns, 0.9) < 0.65 * picture.shape[1]


@pytest.mark.parametrize(('arguments', 'part'), [
    ('none.csv', 'none.csv: cannot be read (No such file or directory)'),
    ('floor.csv --view-size -1', 'view_size is -1.0'),
    ('floor.csv --write floor.csv/floor.dotmap', 'choose a writable place'),
    ('floor.csv --picture floor.csv/floor.png', 'choose a writable place'),
])  # fmt: skip
def test_bad_input_is_one_line_and_exit_code_1(floor, refusal, monkeypatch, arguments, part):
    monkeypatch.chdir(floor.parent)
    assert part in refusal(main, *arguments.split())
