"""The node's choice of the map."""

from __future__ import annotations

from pathlib import Path

from floor_localizer.localization.node_settings import DEMO_MAP, NodeSettings


def test_the_demo_floor_is_taken_only_without_a_map() -> None:
    assert NodeSettings().map_path == DEMO_MAP
    assert NodeSettings(map_file='/data/hall.csv').map_path == Path('/data/hall.csv')


def test_a_tilde_is_the_home_directory() -> None:
    assert NodeSettings(map_file='~/hall.csv').map_path == Path.home() / 'hall.csv'
