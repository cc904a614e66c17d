from pathlib import Path

import numpy as np
import pytest
from dot_maps import random_map
from floor_views import CAMERA, MOUNT, is_right, see

from floor_localizer.core.errors import DotMapError
from floor_localizer.core.localizer import FloorLocalizer
from floor_localizer.files.dot_map_file import load_dot_map, load_indexed_map, save_csv, write_indexed_map
from shirube_core.geometry import SE2


@pytest.fixture
def files(tmp_path: Path) -> tuple[Path, Path]:
    dot_map = random_map(5)
    dot_map.diameters[7] = np.nan
    save_csv(tmp_path / 'floor.csv', dot_map)
    write_indexed_map(tmp_path / 'floor.dotmap', dot_map, load_indexed_map(tmp_path / 'floor.csv'))
    return tmp_path / 'floor.csv', tmp_path / 'floor.dotmap'


def test_both_formats_hold_the_same_dots(files):
    tables = []
    for path in files:
        dot_map = load_dot_map(path)
        table = np.column_stack([dot_map.points, dot_map.diameters])
        tables.append(table[np.lexsort(np.round(dot_map.points, 6).T)])
    np.testing.assert_allclose(tables[1], tables[0], rtol=0, atol=2e-8)
    # The format is recognised by the content, too.
    renamed = files[1].rename(files[1].with_suffix('.bin'))
    assert len(load_dot_map(renamed)) == len(tables[0])


def test_both_formats_give_the_same_pose_and_the_true_one(files):
    pose = SE2(0.2, 0.15, 0.7)
    dots = see(load_dot_map(files[0]), pose, np.random.default_rng(0), noise=0.0).dots
    from_csv, from_binary = (FloorLocalizer(load_indexed_map(path), MOUNT).locate_dots(dots, CAMERA) for path in files)
    assert is_right(from_csv, pose, 1e-6, 1e-5)
    assert from_csv.T_map_base == from_binary.T_map_base
    np.testing.assert_array_equal(from_csv.covariance, from_binary.covariance)


@pytest.mark.parametrize('name', ['none.csv', 'none.dotmap', 'none'])
def test_a_missing_map_is_one_clear_line(tmp_path, name):
    with pytest.raises(DotMapError, match=f'{name}: cannot be read .No such file or directory.; give a dot'):
        load_indexed_map(tmp_path / name)
