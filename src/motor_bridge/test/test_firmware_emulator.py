"""The emulator as a program: symbolic link, fault injection and termination."""

import os
import signal
import subprocess
import sys
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

import serial

from motor_bridge.commands.firmware_emulator import main

EMULATOR = [sys.executable, '-m', 'motor_bridge.commands.firmware_emulator']


@contextmanager
def emulator(*options: str) -> Iterator[tuple[subprocess.Popen[str], str]]:
    pipe = subprocess.PIPE
    program = subprocess.Popen([*EMULATOR, *options], stdin=pipe, stdout=pipe, text=True, start_new_session=True)
    assert program.stdout is not None
    try:
        yield program, program.stdout.readline().strip()
    finally:
        program.kill()
        program.communicate()


def ask(port: serial.Serial, request: bytes) -> bytes:
    port.write(request)
    return port.readline()


def order(program: subprocess.Popen[str], line: str) -> None:
    assert program.stdin is not None
    program.stdin.write(f'{line}\n')
    program.stdin.flush()


def test_it_replies_at_its_link_and_prints_the_final_pose(tmp_path: Path) -> None:
    link = tmp_path / 'tty'
    with emulator('--link', str(link)) as (program, path):
        assert os.path.realpath(link) == path
        with serial.Serial(str(link), 57600, timeout=10) as port:
            assert ask(port, b'b\r') == b'57600\r\n'
            assert ask(port, b'e\r') == b'0 0\r\n'
        program.send_signal(signal.SIGINT)
        said, _ = program.communicate(timeout=20)
        assert said.startswith('final pose: x 0.000 m')
        assert program.returncode == 0
    assert not link.is_symlink()


def test_a_fault_is_ordered_by_a_line_and_a_wrong_line_ends_nothing(tmp_path: Path) -> None:
    with emulator('--link', str(tmp_path / 'tty')) as (program, path):
        order(program, 'dance 3')
        order(program, 'silence 1000')
        with serial.Serial(path, 57600, timeout=0.3) as port:
            assert any(ask(port, b'b\r') == b'' for _ in range(50))
        assert program.poll() is None


def test_a_link_that_cannot_be_made_is_one_line_and_replaces_no_file(tmp_path: Path, capsys) -> None:
    path = tmp_path / 'notes'
    path.write_text('mine')
    for link, words in (
        (path, 'exists and is not a symbolic link'),
        (tmp_path / 'no folder' / 'tty', f'firmware_emulator: {tmp_path / "no folder"}'),
    ):
        assert main(['--link', str(link)]) == 1
        (line,) = capsys.readouterr().err.splitlines()
        assert words in line
    assert path.read_text() == 'mine'
