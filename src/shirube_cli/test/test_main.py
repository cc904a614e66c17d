"""What the command answers to good and bad requests."""

import errno
import os
import subprocess
import sys
from pathlib import Path

import pytest

from shirube_cli import develop, run
from shirube_cli.main import COMMANDS, USAGE, main
from shirube_cli.project import safe_environment


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


def test_version_and_help_of_benchmarks_are_answers(capsys: pytest.CaptureFixture[str]) -> None:
    assert main(['--version']) == 0
    assert capsys.readouterr().out.startswith('shirube 0.')
    assert main(['bench', '--help']) == 0
    assert 'tracking' in capsys.readouterr().out


def test_full_device_and_closed_pipe_are_one_line_each() -> None:
    command = [sys.executable, '-m', 'shirube_cli', '--version']
    with Path('/dev/full').open('w') as full:
        done = subprocess.run(command, check=False, stdout=full, stderr=subprocess.PIPE, text=True)
    assert (done.returncode, done.stderr.count('\n')) == (1, 1)
    assert 'the disk is full: cannot write the output' in done.stderr
    reader, writer = os.pipe()
    os.close(reader)
    done = subprocess.run(command, check=False, stdout=writer, stderr=subprocess.PIPE, text=True)
    os.close(writer)
    assert (done.returncode, done.stderr) == (1, 'shirube: nobody reads the output any more\n')


def test_ascii_terminal_is_enough(monkeypatch: pytest.MonkeyPatch) -> None:
    assert USAGE.isascii()
    monkeypatch.setenv('PYTHONIOENCODING', 'ascii')
    command = [sys.executable, '-c', r'print("0.5 \u00b0")']
    printed = subprocess.run(command, env=safe_environment(), check=True, stdout=subprocess.PIPE).stdout
    assert printed == b'0.5 ?\n'


@pytest.mark.parametrize(('number', 'said'), [(errno.ENOSPC, 'the disk is full'), (errno.EROFS, 'folder of your own')])
def test_refusal_of_the_disk_is_one_line_with_the_remedy(
    number: int, said: str, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    def refuse() -> None:
        raise OSError(number, 'refused', '/out')

    monkeypatch.setattr(run, 'find_home', refuse)
    assert main(['list']) == 1
    line = capsys.readouterr().err
    assert line.startswith('shirube: ')
    assert said in line
    assert '/out; ' in line


@pytest.mark.parametrize(
    ('arguments', 'program'), [(['paper_tables', '--tables', '1'], 'paper_tables.py'), (['--tables'], '_run_all.py')]
)
def test_tables_of_a_benchmark_are_its_own(arguments: list[str], program: str, monkeypatch: pytest.MonkeyPatch) -> None:
    commands: list[list[str]] = []

    def note(command: list[str], **_: object) -> subprocess.CompletedProcess[bytes]:
        commands.append(command)
        return subprocess.CompletedProcess(command, 0)

    monkeypatch.setattr(develop, 'install_development_packages', lambda: None)
    monkeypatch.setattr(subprocess, 'run', note)
    assert develop.bench(arguments) == 0
    assert Path(commands[0][1]).name == program


def test_list_names_executables_and_benchmarks(capsys: pytest.CaptureFixture[str]) -> None:
    assert main(['list']) == 0
    lines = capsys.readouterr().out.splitlines()
    assert [line.split() for line in lines if 'shirube_bags' in line] == [['shirube_bags', 'check,', 'play,', 'record']]
    assert '  tracking' in lines
