import json
from pathlib import Path

import pytest

from vlc_beacon.commands import renew_counters
from vlc_beacon.core.authorization.keys_and_counters import Counters
from vlc_beacon.core.vlc_beacon_error import VlcBeaconError
from vlc_beacon.files.authorization_files import CounterFile

COUNTERS = Counters(7, {1: 5, 300: 9}, {1: 4294967295})
GOOD = {'format': 1, 'floor': 0, 'zone_rules': {}, 'one_shots': {}}


def error_of(path: Path) -> str:
    with pytest.raises(VlcBeaconError) as caught:
        CounterFile(path).read()
    assert '\n' not in str(caught.value)
    return str(caught.value)


def test_counters_come_back(tmp_path: Path) -> None:
    file = CounterFile(tmp_path / 'robot' / 'counters.json')
    file.write(COUNTERS)
    assert file.read() == COUNTERS
    file.write(Counters())
    assert file.read() == Counters()
    assert [path.name for path in (tmp_path / 'robot').iterdir()] == ['counters.json']


def test_a_lost_file_is_not_an_empty_one(tmp_path: Path) -> None:
    path = tmp_path / 'counters.json'
    remedy = 'reset it with renew_counters, with a new key or above all counters used'
    assert error_of(path) == f'counter file {path} is missing; {remedy}'
    CounterFile(path).reset(1_700_000_000)
    assert CounterFile(path).read() == Counters(1_700_000_000)


@pytest.mark.parametrize(
    'content',
    [
        *('', '{', '[]', 'null', '[' * 100_000, '\x00' * 50, json.dumps({**GOOD, 'format': 2})),
        *(json.dumps({**GOOD, 'floor': floor}) for floor in (-1, True, 1.5)),
        *(json.dumps({**GOOD, 'zone_rules': rules}) for rules in (None, {'a': 1}, {'16384': 1})),
        *(json.dumps({**GOOD, 'one_shots': {'1': counter}}) for counter in (1 << 32, '1')),
    ],
    ids=lambda content: content[:40],
)
def test_a_damaged_file_is_named(tmp_path: Path, content: str) -> None:
    path = tmp_path / 'counters.json'
    path.write_text(content)
    assert error_of(path).startswith(f'counter file {path} is corrupted: ')


def test_what_cannot_be_read_or_written_is_named(tmp_path: Path) -> None:
    assert error_of(tmp_path) == f'counter file {tmp_path} cannot be read: Is a directory'
    (tmp_path / 'file').write_text('')
    with pytest.raises(VlcBeaconError, match=r'counter file .*/file/c.json cannot be written: '):
        CounterFile(tmp_path / 'file' / 'c.json').write(COUNTERS)


def test_counters_begin_at_the_floor_which_may_not_be_out_of_range(tmp_path: Path, capsys) -> None:
    path = tmp_path / 'counters'
    assert renew_counters.main([str(path), '--floor', '40']) == 0
    for floor in (-1, 1 << 32):
        assert renew_counters.main([str(path), '--floor', str(floor)]) == 1
        (line,) = capsys.readouterr().err.splitlines()
        assert f'floor of the counters is {floor}, it must be from 0' in line
    assert CounterFile(path).read() == Counters(40)
