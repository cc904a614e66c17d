"""Files of the command authorization: the key, and the counters of the senders."""

import json
import os
import secrets
import stat
from pathlib import Path

from shirube_core.files import atomic_write
from vlc_beacon.core.authorization.keys_and_counters import KEY_BYTES_MAX, KEY_BYTES_MIN, CommandKey, Counters
from vlc_beacon.core.packet.command_packet import COUNTER_MAX
from vlc_beacon.core.packet.data_packet import BEACON_ID_MAX
from vlc_beacon.core.vlc_beacon_error import VlcBeaconError

_GROUP_AND_OTHERS = stat.S_IRWXG | stat.S_IRWXO
_KEY_SIZE_MAX = 4096


def read_key(path: Path) -> CommandKey:
    """Return the key in a file; raises `VlcBeaconError` if others can read it, or it has no valid key."""
    try:
        # Without O_NONBLOCK a named pipe would block forever.
        handle = os.open(path, os.O_RDONLY | os.O_CLOEXEC | os.O_NONBLOCK)
        try:
            status = os.fstat(handle)
            content = os.read(handle, _KEY_SIZE_MAX) if stat.S_ISREG(status.st_mode) else b''
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


FORMAT = 1
_KINDS = ('zone_rules', 'one_shots')
_COUNTERS_SIZE_MAX = 1 << 20


class CounterFile:
    """A file of counters in JSON."""

    def __init__(self, path: Path) -> None:
        self._path = path

    def read(self) -> Counters:
        """Return the counters; raises `VlcBeaconError` if the file is missing, unreadable or corrupted."""
        remedy = 'reset it with renew_counters, with a new key or above all counters used'
        try:
            with self._path.open('rb') as file:
                content = file.read(_COUNTERS_SIZE_MAX)
        except FileNotFoundError as error:
            raise VlcBeaconError(f'counter file {self._path} is missing; {remedy}') from error
        except OSError as error:
            raise VlcBeaconError(f'counter file {self._path} cannot be read: {error.strerror}') from error
        try:
            return _parse_counters(json.loads(content))
        except (ValueError, RecursionError) as error:
            raise VlcBeaconError(f'counter file {self._path} is corrupted: {error}; {remedy}') from error

    def write(self, counters: Counters) -> None:
        """Sync the counters to disk; raises `VlcBeaconError` if the file cannot be written."""
        fields = {'format': FORMAT, 'floor': counters.floor}
        kinds = {kind: {str(b): c for b, c in sorted(getattr(counters, kind).items())} for kind in _KINDS}
        try:
            with atomic_write(self._path) as file:
                file.write((json.dumps({**fields, **kinds}, indent=2) + '\n').encode())
                file.flush()
                os.fsync(file.fileno())
            # The entry of the file in its directory, too.
            handle = os.open(self._path.parent, os.O_RDONLY)
            try:
                os.fsync(handle)
            finally:
                os.close(handle)
        except OSError as error:
            raise VlcBeaconError(f'counter file {self._path} cannot be written: {error.strerror}') from error

    def reset(self, floor: int) -> None:
        """Reset the file: counters below the floor are rejected; raises `VlcBeaconError`."""
        if not 0 <= floor <= COUNTER_MAX:
            raise VlcBeaconError(f'floor of the counters is {floor}, it must be from 0 to {COUNTER_MAX}')
        self.write(Counters(floor))


def _parse_counters(fields: object) -> Counters:
    """Parse the counters; raises `ValueError` if a field is missing or wrong."""
    if not isinstance(fields, dict) or fields.get('format') != FORMAT:
        raise ValueError(f'its format is not {FORMAT}')
    zone_rules, one_shots = (_parse_counters_by_beacon(fields.get(kind), kind) for kind in _KINDS)
    return Counters(_parse_counter(fields.get('floor'), 'floor'), zone_rules, one_shots)


def _parse_counters_by_beacon(entries: object, kind: str) -> dict[int, int]:
    if not isinstance(entries, dict) or not all(0 <= int(beacon) <= BEACON_ID_MAX for beacon in entries):
        raise ValueError(f'{kind} is missing or has an invalid beacon ID')
    return {int(beacon): _parse_counter(counter, kind) for beacon, counter in entries.items()}


def _parse_counter(value: object, name: str) -> int:
    if not isinstance(value, int) or isinstance(value, bool) or not 0 <= value <= COUNTER_MAX:
        raise ValueError(f'{name} has the counter {value!r}')
    return value
