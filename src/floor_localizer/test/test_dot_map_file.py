from pathlib import Path

import numpy as np
import pytest
from dot_maps import random_map

from floor_localizer.core.dots import DetectedDots
from floor_localizer.core.errors import DotMapError
from floor_localizer.core.fix import Fix
from floor_localizer.core.localizer import FloorLocalizer
from floor_localizer.files.csv_format import save_csv
from floor_localizer.files.dot_map_file import load_dot_map, load_indexed_map, write_indexed_map
from shirube_core.geometry import SE2, CameraMount, PinholeCamera

CAMERA = PinholeCamera(235, 235, 339.44, 339.44, 117.0, 117.0)
MOUNT = CameraMount()


@pytest.fixture
def files(tmp_path: Path) -> tuple[Path, Path]:
    dot_map = random_map(5)
    dot_map.diameters[7] = np.nan
    save_csv(tmp_path / 'floor.csv', dot_map)
    write_indexed_map(tmp_path / 'floor.dotmap', dot_map, load_indexed_map(tmp_path / 'floor.csv'))
    return tmp_path / 'floor.csv', tmp_path / 'floor.dotmap'


def view_of(points: np.ndarray, pose: SE2) -> DetectedDots:
    pixels = CAMERA.pixels_from_points(MOUNT.camera_points_from_floor(pose.inverse().transform(points)))
    pixels = pixels[(np.abs(pixels - 117.0) < 115.0).all(axis=1)]
    return DetectedDots(pixels, np.full(len(pixels), 7.0), np.full(len(pixels), 0.2))


def test_both_formats_hold_the_same_dots(files):
    tables = []
    for path in files:
        dot_map = load_dot_map(path)
        table = np.column_stack([dot_map.points, dot_map.diameters])
        tables.append(table[np.lexsort(np.round(dot_map.points, 6).T)])
    np.testing.assert_allclose(tables[1], tables[0], rtol=0, atol=2e-8)


def test_both_formats_give_the_same_pose_and_the_true_one(files):
    pose = SE2(0.2, 0.15, 0.7)
    dots = view_of(load_dot_map(files[0]).points, pose)
    from_csv, from_binary = (
        FloorLocalizer(load_indexed_map(path), MOUNT).locate_dots(dots, CAMERA) for path in files
    )
    assert isinstance(from_csv, Fix)
    assert isinstance(from_binary, Fix)
    assert from_csv.T_map_base == from_binary.T_map_base
    np.testing.assert_array_equal(from_csv.covariance, from_binary.covariance)
    assert from_csv.T_map_base.distance_to(pose) < 1e-6
    assert abs(from_csv.T_map_base.yaw_to(pose)) < 1e-5


def test_the_format_is_recognised_by_the_content_too(files):
    renamed = files[1].rename(files[1].with_suffix('.bin'))
    assert len(load_dot_map(renamed)) == len(load_dot_map(files[0]))


@pytest.mark.parametrize('name', ['none.csv', 'none.dotmap', 'none'])
def test_a_missing_map_is_one_clear_line(tmp_path, name):
    with pytest.raises(
        DotMapError, match=f'{name}: cannot be read .No such file or directory.; give a dot map'
    ):
        load_indexed_map(tmp_path / name)
