"""Loading of the static map."""

import re

import numpy as np
import pytest

from reward_planner.core.navigator import Navigator, NavigatorSettings
from reward_planner.core.occupancy_map import GridFrame, OccupancyMap
from reward_planner.core.voxels.voxel_settings import VoxelSettings
from reward_planner.files.occupancy_map_file import save_occupancy_map
from reward_planner.interface.map_server import load_static_map
from reward_planner.node_settings import NodeSettings
from shirube_core.geometry import CameraMount


def load(path, x, y):
    """Save a map with an occupied cell at its origin, load it; return where the cell is, and the warning."""
    cells = np.zeros((8, 8), dtype=np.int8)
    cells[0, 0] = 100
    save_occupancy_map(path, OccupancyMap(GridFrame(x, y, 0.1, 8, 8), cells))
    settings = NavigatorSettings(VoxelSettings(resolution=0.1))
    navigator = Navigator(CameraMount((0.0, 0.0, 0.3), (0.0, 0.0, 0.0)), settings)
    warning = load_static_map(navigator, NodeSettings(map_file=str(path)))
    frame, known = navigator.mapper.map.occupancy()
    row, column = np.argwhere(known == 100)[0]
    return frame.origin_x + 0.1 * column, frame.origin_y + 0.1 * row, warning


def test_a_map_in_step_stays_and_the_shift_of_one_out_of_step_is_reported(tmp_path):
    path = tmp_path / 'a.yaml'
    shift = f'{path}: .* the map is shifted by -30 mm in x and -40 mm in y'
    for at, words in (((-1.3, 0.7), ''), ((-1.27, 0.74), shift)):
        x, y, warning = load(path, *at)
        assert (x, y) == pytest.approx((-1.3, 0.7))
        assert re.fullmatch(words, warning)


def test_no_map_is_no_warning():
    settings = NavigatorSettings()
    navigator = Navigator(CameraMount((0.0, 0.0, 0.3), (0.0, 0.0, 0.0)), settings)
    assert load_static_map(navigator, NodeSettings()) == ''
