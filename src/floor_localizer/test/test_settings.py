"""Defaults are within their ranges, and every setting has a description."""

from pathlib import Path

import pytest

from floor_localizer.core.settings import LocalizerSettings, TrackerSettings
from floor_localizer.localization.localizer_from_map_file import DEMO_MAP, NodeSettings
from shirube_core.settings import check_settings, describe_settings


@pytest.mark.parametrize('kind', [LocalizerSettings, TrackerSettings])
def test_defaults_are_allowed_and_every_setting_is_described_and_bounded(kind):
    check_settings(kind())
    for described in describe_settings(kind):
        assert described.description
        if not described.choices and described.type is not bool:
            assert described.minimum <= described.default <= described.maximum


def test_the_demo_floor_is_taken_only_without_a_map_and_a_tilde_is_the_home():
    assert NodeSettings().map_path == DEMO_MAP
    assert NodeSettings(map_file='/data/hall.csv').map_path == Path('/data/hall.csv')
    assert NodeSettings(map_file='~/hall.csv').map_path == Path.home() / 'hall.csv'
