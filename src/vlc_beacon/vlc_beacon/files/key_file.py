"""Key file: hexadecimal digits in a file that only its owner can read."""

import os
import secrets
import stat
from pathlib import Path

from vlc_beacon.core.authorization.command_key import KEY_BYTES_MAX, KEY_BYTES_MIN, CommandKey
from vlc_beacon.core.vlc_beacon_error import VlcBeaconError

_GROUP_AND_OTHERS = stat.S_IRWXG | stat.S_IRWXO
_SIZE_MAX = 4096


def read_key(path: Path) -> CommandKey:
    """Return the key in a file; raises `VlcBeaconError` if others can read it, or it has no valid key."""
    try:
        # Without O_NONBLOCK a named pipe would block forever.
        handle = os.open(path, os.O_RDONLY | os.O_CLOEXEC | os.O_NONBLOCK)
        try:
            status = os.fstat(handle)
            content = os.read(handle, _SIZE_MAX) if stat.S_ISREG(status.st_mode) else b''
        finally:
            os.close(handle)
    except OSError as error:
        raise VlcBeaconError(f'key file {path} cannot be read: {error.strerror}') from error
    if not stat.S_ISREG(status.st_mode):
        raise VlcBeaconError(f'key file {path} is not a regular file')
    if status.st_mode & _GROUP_AND_OTHERS:
        raise VlcBeaconError(f'key file {path} is accessible to other users; run: chmod 600 {path}')
    if status.st_uid not in (os.geteuid(), 0):
        raise VlcBeaconError(f'key file {path} belongs to another user; run: chown {os.geteuid()} {path}')
    return _parse_key(content, path)


def make_key_file(path: Path) -> None:
    """Write a new key that only its owner can read; raises `VlcBeaconError` if the file exists."""
    try:
        handle = os.open(path, os.O_WRONLY | os.O_CREAT | os.O_EXCL | os.O_CLOEXEC, 0o600)
    except OSError as error:
        raise VlcBeaconError(f'key file {path} cannot be created: {error.strerror}') from error
    try:
        with os.fdopen(handle, 'w') as file:
            file.write(secrets.token_hex(KEY_BYTES_MAX) + '\n')
    except OSError as error:
        # A truncated key would be accepted as a key.
        path.unlink()
        raise VlcBeaconError(f'key file {path} cannot be written: {error.strerror}') from error


def _parse_key(content: bytes, path: Path) -> CommandKey:
    remedy = f'it must hold {2 * KEY_BYTES_MIN} to {2 * KEY_BYTES_MAX} hexadecimal digits and nothing else'
    try:
        return CommandKey(bytes.fromhex(content.decode('ascii')))
    except ValueError as error:
        raise VlcBeaconError(f'key file {path} has no valid key: {remedy}') from error
