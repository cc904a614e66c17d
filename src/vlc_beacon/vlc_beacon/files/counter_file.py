"""Counter file: the last accepted counters, kept over restarts.

Without the file a robot cannot detect replays, so it rejects all commands until the file is reset. With a new key the
counters may start at 0, because commands signed with the old key are invalid. With the old key they must start above
all counters ever used, and the lamps must be given new commands. Counters in seconds since 1970 satisfy both.
"""

import json
import os
from pathlib import Path

from shirube_core.files import atomic_write
from vlc_beacon.core.authorization.counters import Counters
from vlc_beacon.core.packet.command_packet import COUNTER_MAX
from vlc_beacon.core.packet.id_packet import BEACON_ID_MAX
from vlc_beacon.core.vlc_beacon_error import VlcBeaconError

FORMAT = 1
_KINDS = ('zone_rules', 'one_shots')
_SIZE_MAX = 1 << 20


class CounterFile:
    """A file of counters in JSON."""

    def __init__(self, path: Path) -> None:
        self._path = path

    def read(self) -> Counters:
        """Return the counters; raises `VlcBeaconError` if the file is missing, unreadable or corrupted."""
        remedy = 'reset it with renew_counters, with a new key or above all counters used'
        try:
            with self._path.open('rb') as file:
                content = file.read(_SIZE_MAX)
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
