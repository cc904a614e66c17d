"""The counter file: which commands were heard last, kept over restarts.

A robot that lost the file cannot tell a replay from a new command, so it refuses all commands until its owner renews
the file. Renewed with a new key, it may begin at 0: what was signed with the old key is worthless. With the old key it
must begin above all counters ever used, and the lamps must be given their commands anew. Who counts by the clock,
in seconds since 1970, gets both from the time of day.
"""

from __future__ import annotations

import json
import os
from pathlib import Path

from shirube_files import written_beside
from vlc_beacon.core.packet.command_packet import COUNTER_MAX
from vlc_beacon.core.packet.id_packet import BEACON_ID_MAX
from vlc_beacon.core.trust.counters import Counters
from vlc_beacon.core.vlc_beacon_error import VlcBeaconError

FORMAT = 1
_KINDS = ('zone_rules', 'one_shots')
_SIZE_MAX = 1 << 20


class CounterFile:
    """A file of counters in JSON.

    Args:
        path: of the file.
    """

    def __init__(self, path: Path) -> None:
        self._path = path

    def read(self) -> Counters:
        """Return the counters.

        Raises:
            VlcBeaconError: the file is missing, unreadable or damaged.
        """
        remedy = 'renew it, with a new key or above all counters used'
        try:
            with self._path.open('rb') as file:
                content = file.read(_SIZE_MAX)
        except FileNotFoundError as error:
            raise VlcBeaconError(f'counter file {self._path} is missing; {remedy}') from error
        except OSError as error:
            raise VlcBeaconError(f'counter file {self._path} cannot be read: {error.strerror}') from error
        try:
            return _counters_of(json.loads(content))
        except (ValueError, RecursionError) as error:
            raise VlcBeaconError(f'counter file {self._path} is damaged: {error}; {remedy}') from error

    def write(self, counters: Counters) -> None:
        """Keep counters; they are on the disk when this returns.

        Raises:
            VlcBeaconError: the file cannot be written.
        """
        fields = {'format': FORMAT, 'floor': counters.floor}
        kinds = {kind: {str(b): c for b, c in sorted(getattr(counters, kind).items())} for kind in _KINDS}
        try:
            with written_beside(self._path) as file:
                file.write((json.dumps({**fields, **kinds}, indent=2) + '\n').encode())
                file.flush()
                os.fsync(file.fileno())
            _sync_folder(self._path.parent)
        except OSError as error:
            raise VlcBeaconError(f'counter file {self._path} cannot be written: {error.strerror}') from error

    def renew(self, floor: int) -> None:
        """Begin anew, with commands below the floor refused.

        Args:
            floor: 0 with a new key, otherwise above all counters used.

        Raises:
            VlcBeaconError: the floor is out of range, or the file cannot be written.
        """
        if not 0 <= floor <= COUNTER_MAX:
            raise VlcBeaconError(f'floor of the counters is {floor}, it must be from 0 to {COUNTER_MAX}')
        self.write(Counters(floor))


def _sync_folder(folder: Path) -> None:
    """Have the renaming on the disk too."""
    handle = os.open(folder, os.O_RDONLY)
    try:
        os.fsync(handle)
    finally:
        os.close(handle)


def _counters_of(fields: object) -> Counters:
    """Return the counters of the file's content.

    Raises:
        ValueError: a field is missing or has a wrong value.
    """
    if not isinstance(fields, dict) or fields.get('format') != FORMAT:
        raise ValueError(f'it is not of format {FORMAT}')
    zone_rules, one_shots = (_by_beacon(fields.get(kind), kind) for kind in _KINDS)
    return Counters(_counter(fields.get('floor'), 'floor'), zone_rules, one_shots)


def _by_beacon(entries: object, kind: str) -> dict[int, int]:
    if not isinstance(entries, dict) or any(
        int(beacon) not in range(BEACON_ID_MAX + 1) for beacon in entries
    ):
        raise ValueError(f'{kind} is missing or names a beacon that cannot be')
    return {int(beacon): _counter(counter, kind) for beacon, counter in entries.items()}


def _counter(value: object, name: str) -> int:
    if not isinstance(value, int) or isinstance(value, bool) or not 0 <= value <= COUNTER_MAX:
        raise ValueError(f'{name} has the counter {value!r}')
    return value
