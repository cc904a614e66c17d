import os
import secrets
import stat
from pathlib import Path

import pytest

from vlc_beacon.core.authorization.command_key import CommandKey
from vlc_beacon.core.packet.command_packet import Command
from vlc_beacon.core.vlc_beacon_error import VlcBeaconError
from vlc_beacon.files.key_file import make_key_file, read_key

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


def test_a_new_key_is_secret_and_never_the_same(tmp_path: Path) -> None:
    paths = [tmp_path / 'a', tmp_path / 'b']
    for path in paths:
        make_key_file(path)
        assert stat.S_IMODE(path.stat().st_mode) == 0o600
    first, second = (read_key(path) for path in paths)
    assert not second.is_authentic(first.sign(COMMAND))
    assert read_key(paths[0]).is_authentic(first.sign(COMMAND))
    with pytest.raises(VlcBeaconError, match=r'key file .*/a cannot be created: File exists'):
        make_key_file(paths[0])


def test_the_key_is_what_the_digits_say(tmp_path: Path) -> None:
    path = written(tmp_path / 'key', ' 000102030405060708090A0B0C0D0E0F\n')
    assert CommandKey(bytes(range(16))).is_authentic(read_key(path).sign(COMMAND))


@pytest.mark.parametrize('mode', [0o640, 0o604, 0o620, 0o602, 0o644, 0o610])
def test_a_key_accessible_to_others_is_rejected(tmp_path: Path, mode: int) -> None:
    path = written(tmp_path / 'key', '00' * 32, mode)
    assert error_of(path) == f'key file {path} is accessible to other users; run: chmod 600 {path}'


@pytest.mark.parametrize('text', ['', '00' * 15, '00' * 33, 'secret' * 8, '0' * 33, 'ß' * 32, '00' * 9000])
def test_a_malformed_key_is_rejected(tmp_path: Path, text: str) -> None:
    path = written(tmp_path / 'key', text)
    expected = f'key file {path} has no valid key: it must hold 32 to 64 hexadecimal digits and nothing else'
    assert error_of(path) == expected


def test_a_key_that_is_not_a_file_is_rejected(tmp_path: Path) -> None:
    assert (
        error_of(tmp_path / 'none')
        == f'key file {tmp_path / "none"} cannot be read: No such file or directory'
    )
    assert error_of(tmp_path) == f'key file {tmp_path} is not a regular file'
    os.mkfifo(tmp_path / 'pipe', 0o600)
    assert error_of(tmp_path / 'pipe') == f'key file {tmp_path / "pipe"} is not a regular file'


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
