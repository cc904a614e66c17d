"""Defaults are within their ranges, and every setting has a description."""

from dataclasses import replace
from pathlib import Path

import pytest

from floor_localizer.core.settings import LocalizerSettings, TrackerSettings
from floor_localizer.localization.localizer_from_map_file import DEMO_MAP, NodeSettings
from shirube_core.settings import SettingsError, check_settings, describe_settings

KINDS = [LocalizerSettings, TrackerSettings]


@pytest.mark.parametrize('kind', KINDS)
def test_defaults_are_allowed_and_every_setting_is_described_and_bounded(kind):
    check_settings(kind())
    for described in describe_settings(kind):
        assert described.description
        assert described.minimum <= described.default <= described.maximum


@pytest.mark.parametrize('kind', KINDS)
def test_what_is_out_of_range_is_refused_by_name(kind):
    for described in describe_settings(kind):
        for value in (described.minimum - 1, described.maximum + 1):
            with pytest.raises(SettingsError, match=described.name):
                check_settings(replace(kind(), **{described.name: value}))


def test_the_demo_floor_is_taken_only_without_a_map_and_a_tilde_is_the_home():
    assert NodeSettings().map_path == DEMO_MAP
    assert NodeSettings(map_file='/data/hall.csv').map_path == Path('/data/hall.csv')
    assert NodeSettings(map_file='~/hall.csv').map_path == Path.home() / 'hall.csv'
