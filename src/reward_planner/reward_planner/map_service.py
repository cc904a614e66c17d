"""Loads and saves the map."""

from __future__ import annotations

from pathlib import Path

from reward_planner.core.grid.occupancy_map import OccupancyMap
from reward_planner.core.navigator import Navigator
from reward_planner.core.reward_planner_error import RewardPlannerError
from reward_planner.files.occupancy_map_file import (
    check_yaml_suffix,
    load_occupancy_map,
    save_occupancy_map,
)
from reward_planner.node_settings import NodeSettings

_SHIFT_MIN = 0.01  # smaller shifts are rounding errors of the file [cells]


def load_static_map(navigator: Navigator, settings: NodeSettings) -> str:
    """Load map_file into a navigator, if it is set; return a one-line warning of a shift, empty if there is none.

    Raises:
        RewardPlannerError: the file is missing or corrupted, has another resolution or too many cells, or save_file has
            a wrong suffix.
    """
    if settings.save_file:
        check_yaml_suffix(Path(settings.save_file))
    if not settings.map_file:
        return ''
    grid = load_occupancy_map(Path(settings.map_file), navigator.mapper.map.resolution)
    navigator.set_static_map(grid)
    side = grid.frame.resolution
    dx, dy = (side * (round(at / side) - at / side) for at in (grid.frame.origin_x, grid.frame.origin_y))
    if max(abs(dx), abs(dy)) < _SHIFT_MIN * side:
        return ''
    return (
        f'{settings.map_file}: its origin is not a multiple of its resolution; the map is shifted by '
        f'{1e3 * dx:.0f} mm in x and {1e3 * dy:.0f} mm in y'
    )


def save_global_map(navigator: Navigator, settings: NodeSettings) -> str:
    """Save the map and return the name of its file.

    Raises:
        RewardPlannerError: the map is empty, no file is set, or it cannot be written.
    """
    name = settings.save_file or settings.map_file
    if not name:
        raise RewardPlannerError('no file to save to; set save_file')
    known = navigator.mapper.map.occupancy()
    if known is None:
        raise RewardPlannerError('the map is empty; wait for the first frame')
    try:
        save_occupancy_map(Path(name), OccupancyMap(*known))
    except OSError as fault:
        raise RewardPlannerError(f'{name}: {fault.strerror}; choose a writable path') from fault
    return name
