"""Windows contain all points within range, and consist of whole tiles."""

from __future__ import annotations

import numpy as np
import pytest

from reward_planner.core.reward_planner_error import RewardPlannerError
from reward_planner.core.voxels.frame_window import TILE_SIZE, SensorView, window_around, window_shape
from reward_planner.core.voxels.voxel_settings import VoxelSettings


def view_at(x, y):
    T = np.eye(4)
    T[:2, 3] = x, y
    return SensorView(T, 500.0)


@pytest.mark.parametrize('resolution', [0.02, 0.05, 0.13])
def test_all_points_within_range_are_in_the_window(resolution):
    settings = VoxelSettings(resolution=resolution, tiles_max=100_000)
    rng = np.random.default_rng(0)
    for x, y in rng.uniform(-1000.0, 1000.0, (200, 2)):
        window = window_around(view_at(x, y), settings)
        first = np.floor((np.array([x, y]) - settings.range_max - window.corner[:2]) / resolution)
        last = np.floor((np.array([x, y]) + settings.range_max - window.corner[:2]) / resolution)
        assert (first >= 0).all()
        assert (last < window.side).all()
        assert window.side % TILE_SIZE == 0


def test_layers_reach_from_the_lowest_to_the_highest_height():
    assert window_shape(VoxelSettings(height_min=0.1, height_max=1.2, resolution=0.05))[1] == 22
    assert window_shape(VoxelSettings(height_min=0.1, height_max=1.21, resolution=0.05))[1] == 23


@pytest.mark.parametrize(
    ('settings', 'words'),
    [
        (VoxelSettings(height_min=1.0, height_max=0.5), 'height_max is 0.5'),
        (VoxelSettings(height_min=0.5, height_max=0.5), 'height_min is 0.5'),
        (VoxelSettings(range_min=5.0, range_max=2.0), 'range_min is 5'),
        (VoxelSettings(range_min=2.0, range_max=2.0), 'range_max is 2'),
        (
            VoxelSettings(log_odds_occupied=4.0),
            'log_odds_occupied is 4, it may not be more; log_odds_max is 3.5',
        ),
        (VoxelSettings(log_odds_max=0.9), 'log_odds_max is 0.9'),
        (
            VoxelSettings(log_odds_pass=5.0, log_odds_min=-0.1),
            'log_odds_min is -0.1, it must be -2.5 or less',
        ),
        (VoxelSettings(resolution=0.01, tiles_max=100), 'tiles_max is 100'),
        (
            VoxelSettings(resolution=0.01, range_max=50.0, tiles_max=10**6),
            'more than 2147483647; raise resolution',
        ),
    ],
)
def test_settings_that_contradict_each_other_are_refused(settings, words):
    with pytest.raises(RewardPlannerError, match=words) as refusal:
        window_shape(settings)
    assert '\n' not in str(refusal.value)


def test_a_sensor_beyond_all_maps_is_refused():
    with pytest.raises(RewardPlannerError, match='too far'):
        window_around(view_at(1e15, 0.0), VoxelSettings())
