"""Defaults are within their ranges, and every setting has a description."""

from __future__ import annotations

from dataclasses import replace

import pytest

from floor_localizer.core.settings import LocalizerSettings, TrackerSettings
from shirube_core.settings import SettingsError, check_settings, describe_settings

KINDS = [LocalizerSettings, TrackerSettings]


@pytest.mark.parametrize('kind', KINDS)
def test_defaults_are_allowed(kind):
    check_settings(kind())


@pytest.mark.parametrize('kind', KINDS)
def test_every_setting_is_described_and_bounded(kind):
    for described in describe_settings(kind):
        assert described.description
        assert described.minimum <= described.default <= described.maximum


@pytest.mark.parametrize('kind', KINDS)
def test_what_is_out_of_range_is_refused_by_name(kind):
    for described in describe_settings(kind):
        for value in (described.minimum - 1, described.maximum + 1):
            with pytest.raises(SettingsError, match=described.name):
                check_settings(replace(kind(), **{described.name: value}))
