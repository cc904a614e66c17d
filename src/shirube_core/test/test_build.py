"""Settings from values by name, and former names of options."""

import argparse
from dataclasses import dataclass, field
from typing import Any

import pytest

from shirube_core.settings import SettingsError, describe_settings, reject_former_option, setting, settings_from_values


@dataclass(frozen=True)
class Dots:
    diameter: float = setting(0.002, 'smallest dot kept', 'm', (None, 10.0), former_name='width')
    count: int = setting(5, 'fewest dots')


@dataclass(frozen=True)
class Floor:
    dots: Dots = field(default_factory=lambda: Dots(count=7))
    xyz: tuple[float, float, float] = setting((0.0, 0.0, 0.1), 'where it sits')


def test_values_land_in_their_places_and_the_rest_keeps_its_default() -> None:
    settings = settings_from_values(Floor, {'dots.diameter': 1, 'xyz': [1, 2, 3]})
    assert repr(settings) == repr(Floor(Dots(1.0, 7), (1.0, 2.0, 3.0)))  # whole numbers become floats
    defaults = {description.name: description.default for description in describe_settings(Floor)}
    assert settings_from_values(Floor, defaults) == Floor()


@pytest.mark.parametrize(
    ('values', 'words'),
    [
        ({'dots.diametre': 0.1}, r'dots\.diametre does not exist, did you mean dots\.diameter\?'),
        ({'dots.width': 0.1}, r'dots\.width is now called dots\.diameter; .*shirube migrate'),
        ({'q': 0.1}, r'q does not exist, there are dots\.diameter, dots\.count, xyz'),
        ({'dots.diameter': 11}, r'dots\.diameter is 11.0 m, allowed'),
        ({'xyz': 'abc'}, r"xyz is 'abc', it must be 3 numbers"),
    ],
)
def test_bad_values_and_unknown_names_are_refused(values: dict[str, Any], words: str) -> None:
    with pytest.raises(SettingsError, match=words):
        settings_from_values(Floor, values)


def test_a_former_option_ends_with_its_new_name_and_the_help_shows_no_other(capsys: pytest.CaptureFixture[str]) -> None:
    parser = argparse.ArgumentParser(prog='tool')
    parser.add_argument('--submap-length', type=float, default=2.0)
    reject_former_option(parser, 'piece_length', 'submap_length')
    with pytest.raises(SystemExit):
        parser.parse_args(['--piece-length', '3'])
    assert 'tool: error: --piece-length is now called --submap-length' in capsys.readouterr().err
    assert parser.parse_args([]).submap_length == 2.0
    assert 'piece' not in parser.format_help()
