from pathlib import Path

import pytest

from vlc_beacon.commands import make_key, renew_counters
from vlc_beacon.core.packet.command_packet import Command
from vlc_beacon.files.counter_file import CounterFile
from vlc_beacon.files.key_file import read_key


def test_a_key_is_made_once_and_differs_each_time(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    first, second = tmp_path / 'first', tmp_path / 'second'
    assert make_key.main([str(first)]) == make_key.main([str(second)]) == 0
    command = Command(1, 1, 0.0, 5)
    assert read_key(first).sign(command) != read_key(second).sign(command)
    content = first.read_bytes()
    assert content.decode().strip() not in capsys.readouterr().out
    assert make_key.main([str(first)]) == 1
    assert first.read_bytes() == content
    assert 'exists' in capsys.readouterr().err


def test_counters_begin_at_the_floor(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    path = tmp_path / 'counters'
    assert renew_counters.main([str(path), '--floor', '40']) == 0
    counters = CounterFile(path).read()
    assert not counters.is_new(Command(7, 1, 0.0, 39))
    assert counters.is_new(Command(7, 1, 0.0, 40))
    assert renew_counters.main([str(path), '--floor', '-1']) == 1
    assert len(capsys.readouterr().err.splitlines()) == 1
    assert CounterFile(path).read() == counters
