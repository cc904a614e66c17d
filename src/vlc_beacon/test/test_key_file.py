import os
import secrets
import stat
from pathlib import Path

import pytest

from vlc_beacon.commands import make_key
from vlc_beacon.core.authorization.keys_and_counters import CommandKey
from vlc_beacon.core.packet.command_packet import Command
from vlc_beacon.core.vlc_beacon_error import VlcBeaconError
from vlc_beacon.files.authorization_files import make_key_file, read_key

COMMAND = Command(1, 1, 0.0, 5)


def written(path: Path, text: str, mode: int = 0o600) -> Path:
    path.write_text(text)
    path.chmod(mode)
    return path


def error_of(path: Path) -> str:
    with pytest.raises(VlcBeaconError) as caught:
        read_key(path)
    assert '\n' not in str(caught.value)
    return str(caught.value)


def test_a_new_key_is_secret_and_never_the_same(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    paths = [tmp_path / 'a', tmp_path / 'b']
    for path in paths:
        assert make_key.main([str(path)]) == 0
        assert stat.S_IMODE(path.stat().st_mode) == 0o600
        assert path.read_text().strip() not in capsys.readouterr().out
    first, second = (read_key(path) for path in paths)
    assert not second.is_authentic(first.sign(COMMAND))
    assert make_key.main([str(paths[0])]) == 1
    assert 'a cannot be created: File exists' in capsys.readouterr().err
    assert read_key(paths[0]).is_authentic(first.sign(COMMAND))


def test_the_key_is_what_the_digits_say(tmp_path: Path) -> None:
    path = written(tmp_path / 'key', ' 000102030405060708090A0B0C0D0E0F\n')
    assert CommandKey(bytes(range(16))).is_authentic(read_key(path).sign(COMMAND))


OPEN = 'is accessible to other users; run: chmod 600 {}'
NO_KEY = 'has no valid key: it must hold 32 to 64 hexadecimal digits and nothing else'
MALFORMED = ('', '00' * 15, '00' * 33, 'secret' * 8, '0' * 33, 'ß' * 32, '00' * 9000)


@pytest.mark.parametrize(
    ('text', 'mode', 'complaint'),
    [
        *(('00' * 32, mode, OPEN) for mode in (0o640, 0o604, 0o620, 0o602, 0o644, 0o610)),
        *((text, 0o600, NO_KEY) for text in MALFORMED),
    ],
)
def test_an_open_or_malformed_key_is_rejected(tmp_path, text, mode, complaint) -> None:
    path = written(tmp_path / 'key', text, mode)
    assert error_of(path) == f'key file {path} ' + complaint.format(path)


def test_a_key_that_is_not_a_file_is_rejected(tmp_path: Path) -> None:
    none, pipe = tmp_path / 'none', tmp_path / 'pipe'
    os.mkfifo(pipe, 0o600)
    assert error_of(none) == f'key file {none} cannot be read: No such file or directory'
    for path in (tmp_path, pipe):
        assert error_of(path) == f'key file {path} is not a regular file'


@pytest.mark.skipif(os.geteuid() != 0, reason='only root can give files away and reads whatever it likes')
def test_the_key_of_another_user_is_rejected(tmp_path: Path) -> None:
    path = written(tmp_path / 'key', '00' * 32)
    os.chown(path, 12345, 12345)
    assert error_of(path) == f'key file {path} belongs to another user; run: chown 0 {path}'


@pytest.mark.skipif(os.geteuid() == 0, reason='root reads whatever it likes')
def test_an_unreadable_key_is_rejected(tmp_path: Path) -> None:
    path = written(tmp_path / 'key', '00' * 32, 0o000)
    assert error_of(path) == f'key file {path} cannot be read: Permission denied'


def test_a_full_disk_leaves_no_half_key(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    def no_space(_: int) -> str:
        raise OSError(28, 'No space left on device')

    monkeypatch.setattr(secrets, 'token_hex', no_space)
    with pytest.raises(VlcBeaconError, match='cannot be written: No space left on device'):
        make_key_file(tmp_path / 'key')
    assert not (tmp_path / 'key').exists()
