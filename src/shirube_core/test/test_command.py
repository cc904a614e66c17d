"""Errors of a command are one line on stderr, and its exit code is 1."""

import argparse
from dataclasses import dataclass
from pathlib import Path

import pytest

from shirube_core.command import add_settings, run_command, settings_from
from shirube_core.settings import SettingsError, setting


@pytest.mark.parametrize(('code', 'expected'), [(None, 0), (0, 0), (3, 3)])
def test_the_exit_code_is_that_of_the_work(code: int | None, expected: int) -> None:
    assert run_command('work', lambda: code, ()) == expected


@pytest.mark.parametrize(
    ('fault', 'line'),
    [
        (ValueError('map.csv: is empty'), 'map.csv: is empty'),
        (OSError(28, 'No space left', 'b.csv'), 'b.csv: No space left; choose a writable place'),
        (OSError(28, 'No space left'), 'out: No space left; choose a writable place'),
    ],
)
def test_an_error_is_one_line(fault: Exception, line: str, capsys: pytest.CaptureFixture[str]) -> None:
    def work() -> None:
        raise fault

    assert run_command('work', work, (ValueError,), Path('out')) == 1
    assert capsys.readouterr().err == f'work: {line}\n'


def test_an_internal_error_is_raised() -> None:
    with pytest.raises(ZeroDivisionError):
        run_command('work', lambda: 1 // 0, (ValueError,))


@dataclass(frozen=True)
class Lamp:
    """Settings of a lamp."""

    radius: float = setting(0.03, 'radius, 5 % too large at most', 'm', (0.0, None), former_name='size')
    kind: str = setting('disc', 'its shape', choices=('disc', 'grid'))
    is_on: bool = setting(False, 'whether it is on')


def parse(*arguments: str, names: tuple[str, ...] = ()) -> argparse.Namespace:
    parser = argparse.ArgumentParser()
    add_settings(parser, Lamp, names)
    assert '5 % too large' in parser.format_help()
    return parser.parse_args(arguments)


def test_options_of_settings_are_checked() -> None:
    assert settings_from(parse('--radius', '0.1', '--is-on'), Lamp) == Lamp(0.1, is_on=True)
    assert vars(parse(names=('radius',))) == {'radius': 0.03}
    with pytest.raises(SettingsError, match='kind'):
        settings_from(parse('--kind', 'cube'), Lamp)
    with pytest.raises(SystemExit):
        parse('--size', '0.1')
