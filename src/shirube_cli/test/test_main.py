"""What the command answers to good and bad requests."""

import pytest

from shirube_cli.main import COMMANDS, main


def test_help_names_every_command(capsys: pytest.CaptureFixture[str]) -> None:
    assert main(['--help']) == 0
    shown = capsys.readouterr().out
    assert all(f'\n  {name} ' in shown for name in COMMANDS)


@pytest.mark.parametrize(
    ('arguments', 'said'),
    [
        (['dance'], "no command 'dance'"),
        (['run', 'floor_localizer'], 'usage: shirube run'),
        (['bench', 'nothing'], 'usage: shirube bench'),
        (['demo', 'nowhere'], 'nowhere'),
    ],
)
def test_bad_request_is_one_clear_line_and_exit_code_1(
    arguments: list[str], said: str, capsys: pytest.CaptureFixture[str]
) -> None:
    assert main(arguments) == 1
    first, *_ = capsys.readouterr().err.splitlines()
    assert first.startswith('shirube: ')
    assert said in first
