"""Loading of the static map."""

import re

import numpy as np
import pytest

from reward_planner.core.mapping.global_map import CostmapMasks
from reward_planner.core.navigator import Navigator, NavigatorSettings
from reward_planner.core.occupancy_map import GridFrame, OccupancyMap
from reward_planner.core.reward_planner_error import RewardPlannerError
from reward_planner.core.settings import VoxelSettings
from reward_planner.files.occupancy_map_file import save_occupancy_map
from reward_planner.interface.map_server import load_masks, load_static_map
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


@pytest.mark.parametrize(
    ('kind', 'base', 'multiplier', 'limits'),
    [
        ('percent', 100.0, -1.0, [0.5, 0.5, 0.4, 0.25, 0.025]),
        ('percent', 0.0, 1.0, [0.5, 0.5, 0.1, 0.25, 0.5]),
        ('absolute', 0.0, 0.01, [0.5, 0.5, 0.2, 0.5, 0.5]),
    ],
)
def test_a_speed_mask_limits_as_in_nav2_but_never_to_zero(tmp_path, kind, base, multiplier, limits):
    path = tmp_path / 'mask.yaml'
    cells = np.array([[-1, 0, 20, 50, 100]], dtype=np.int8)
    save_occupancy_map(path, OccupancyMap(GridFrame(1.0, 2.0, 0.5, 5, 1), cells))
    masks = load_masks(NodeSettings(speed_mask_file=str(path), speed_mask_type=kind,
        speed_mask_base=base, speed_mask_multiplier=multiplier))  # fmt: skip
    assert [masks.speed_limit(x, 2.1, 0.5) for x in np.arange(1.1, 3.5, 0.5)] == pytest.approx(limits)
    assert masks.speed_limit(0.9, 2.1, 0.5) == masks.speed_limit(1.1, 2.6, 0.5) == 0.5
    assert CostmapMasks().speed_limit(0.0, 0.0, 0.5) == 0.5


@pytest.mark.parametrize('name', ['keepout_mask_file', 'speed_mask_file'])
def test_a_mask_that_is_malformed_is_refused_with_its_file_and_field(tmp_path, name):
    path = tmp_path / 'mask.yaml'
    path.write_text('image: mask.pgm\nresolution: 0.1\norigin: [0, 0]\noccupied_thresh: 1\nfree_thresh: 0\n')
    navigator = Navigator(CameraMount((0.0, 0.0, 0.3), (0.0, 0.0, 0.0)), NavigatorSettings())
    with pytest.raises(RewardPlannerError, match=r'mask\.yaml: origin is .* must be \[x, y, yaw\]'):
        load_static_map(navigator, NodeSettings(**{name: str(path)}))
