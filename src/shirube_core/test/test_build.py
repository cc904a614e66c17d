"""Settings from values by name, and former names of options."""

from __future__ import annotations

import argparse
from dataclasses import dataclass, field
from typing import Any

import pytest

from shirube_core.settings import (
    SettingsError,
    describe_settings,
    reject_former_option,
    setting,
    settings_from_values,
)


@dataclass(frozen=True)
class Dots:
    diameter: float = setting(0.002, 'smallest dot kept', unit='m', maximum=10.0, former_name='width')
    count: int = setting(5, 'fewest dots')


@dataclass(frozen=True)
class Floor:
    dots: Dots = field(default_factory=lambda: Dots(count=7))
    xyz: tuple[float, float, float] = setting((0.0, 0.0, 0.1), 'where it sits')


def test_values_land_in_their_places_and_the_rest_keeps_its_default() -> None:
    settings = settings_from_values(Floor, {'dots.diameter': 0.5, 'xyz': [1, 2, 3]})
    assert settings == Floor(Dots(0.5, 7), (1.0, 2.0, 3.0))


def test_whole_numbers_become_floats() -> None:
    settings = settings_from_values(Floor, {'dots.diameter': 1, 'xyz': [1, 2, 3]})
    assert isinstance(settings.dots.diameter, float)
    assert all(isinstance(element, float) for element in settings.xyz)


def test_the_described_defaults_make_the_default_settings() -> None:
    defaults = {description.name: description.default for description in describe_settings(Floor)}
    assert settings_from_values(Floor, defaults) == Floor()


@pytest.mark.parametrize(
    ('values', 'words'),
    [
        ({'dots.diametre': 0.1}, r'dots\.diametre does not exist, did you mean dots\.diameter\?'),
        ({'dots.width': 0.1}, r'dots\.width is now called dots\.diameter; .*shirube migrate'),
        ({'q': 0.1}, r'q does not exist, there are dots\.diameter, dots\.count, xyz'),
        ({'dots.diameter': 11}, r'dots\.diameter is 11.0 m, allowed'),
        ({'dots.diameter': True}, r'dots\.diameter is True, it must be a number'),
        ({'dots.count': 1.5}, r'dots\.count is 1.5, it must be a whole number'),
        ({'xyz': 'abc'}, r"xyz is 'abc', it must be 3 numbers"),
        ({'xyz': [1, 2]}, r'xyz is \(1.0, 2.0\), it must be 3 numbers'),
    ],
)
def test_bad_values_and_unknown_names_are_refused(values: dict[str, Any], words: str) -> None:
    with pytest.raises(SettingsError, match=words):
        settings_from_values(Floor, values)


def make_parser() -> argparse.ArgumentParser:
    parser = argparse.ArgumentParser(prog='tool')
    parser.add_argument('--submap-length', type=float, default=2.0)
    reject_former_option(parser, 'piece_length', 'submap_length')
    return parser


def test_a_former_name_ends_with_the_new_one(capsys: pytest.CaptureFixture[str]) -> None:
    with pytest.raises(SystemExit):
        make_parser().parse_args(['--piece-length', '3'])
    assert 'tool: error: --piece-length is now called --submap-length' in capsys.readouterr().err


def test_the_new_name_works_and_the_help_shows_no_other() -> None:
    assert make_parser().parse_args([]).submap_length == 2.0
    assert make_parser().parse_args(['--submap-length', '3']).submap_length == 3.0
    assert 'piece' not in make_parser().format_help()
