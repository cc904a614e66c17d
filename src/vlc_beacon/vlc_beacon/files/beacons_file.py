"""Beacons file (YAML): ``beacons: [{id: 1, xyz: [x, y, z], radius: 0.0325, frequency: ...}]``."""

import math
from collections import Counter
from collections.abc import Sequence
from difflib import get_close_matches
from pathlib import Path
from typing import Any

import yaml

from shirube_core.files import YamlFileError, read_yaml, write_text
from vlc_beacon.core.packet.data_packet import BEACON_ID_MAX
from vlc_beacon.core.pose.lamp_rays import Beacon
from vlc_beacon.core.vlc_beacon_error import VlcBeaconError

_REMEDY = 'give beacons: [{id: 1, xyz: [x, y, z], radius: 0.0325}]'
_NEEDED = ('id', 'xyz', 'radius')
_FIELDS = (*_NEEDED, 'frequency')
COORDINATE_RANGE = (-10000.0, 10000.0)
"""Range of coordinates [m]."""
RADIUS_RANGE = (0.001, 1.0)
"""Range of lamp radii [m]."""
FREQUENCY_RANGE = (50.0, 100000.0)
"""Range of tones [Hz]."""
SEPARATION_MIN = 0.01
"""Minimum distance between two lamps [m]; closer ones are duplicates."""
_BYTES_MAX = 1 << 20
"""Maximum file size."""
_HUGE = 1e15
"""Larger numbers are not printed in error messages."""


class BeaconsFileError(VlcBeaconError):
    """Invalid beacons file; the message is one line with file, beacon, field and remedy."""


def load_beacons(path: Path) -> list[Beacon]:
    """Load the beacons, in the order of the file; raises `BeaconsFileError` for any flaw."""
    try:
        content = read_yaml(path, _BYTES_MAX)
    except YamlFileError as error:
        raise BeaconsFileError(f'{error}; {_REMEDY}') from error
    _check_fields(f'{path}', content, ('beacons',), ('beacons',))
    entries = content['beacons']
    if not isinstance(entries, list) or not entries:
        raise BeaconsFileError(f'{path}: beacons holds no lamps; {_REMEDY}')
    beacons = [_parse_beacon(path, number, entry) for number, entry in enumerate(entries, start=1)]
    _check_duplicates(path, beacons)
    return beacons


def save_beacons(path: Path, beacons: Sequence[Beacon]) -> None:
    """Write beacons atomically, positions rounded to 0.1 mm; raises `OSError`."""
    entries = []
    for beacon in beacons:
        entry = {'id': beacon.id, 'xyz': [round(x, 4) for x in beacon.xyz], 'radius': beacon.radius}
        entries.append(entry if beacon.frequency is None else {**entry, 'frequency': beacon.frequency})
    write_text(path, yaml.safe_dump({'beacons': entries}, sort_keys=False, default_flow_style=None))


def _check_fields(where: str, content: dict[str, Any], needed: tuple[str, ...], allowed: tuple[str, ...]) -> None:
    for name in content:
        if name not in allowed:
            close = get_close_matches(str(name), allowed, n=1)
            remedy = f'did you mean {close[0]}?' if close else f'there are {", ".join(allowed)}'
            raise BeaconsFileError(f'{where}: field {name} does not exist, {remedy}')
    missing = next((name for name in needed if name not in content), None)
    if missing is not None:
        raise BeaconsFileError(f'{where}: {missing} is missing; {_REMEDY}')


def _parse_beacon(path: Path, number: int, entry: object) -> Beacon:
    """Parse a beacon; ``number`` is its index in the list, from 1."""
    where = f'{path}: beacon number {number}'
    if not isinstance(entry, dict):
        raise BeaconsFileError(f'{where} is {entry!r}; {_REMEDY}')
    _check_fields(where, entry, _NEEDED, _FIELDS)
    id_, xyz, frequency = entry['id'], entry['xyz'], entry.get('frequency')
    if isinstance(id_, bool) or not isinstance(id_, int) or not 0 <= id_ <= BEACON_ID_MAX:
        raise BeaconsFileError(f'{where}: id is {id_!r}, it must be a whole number from 0 to {BEACON_ID_MAX}')
    where = f'{path}: beacon {id_}'
    if not isinstance(xyz, list) or len(xyz) != 3:
        raise BeaconsFileError(f'{where}: xyz is {xyz!r}, it must be three numbers [x, y, z] in metres')
    x, y, z = (_parse_number(f'{where}: xyz', value, COORDINATE_RANGE, 'm') for value in xyz)
    radius = _parse_number(f'{where}: radius', entry['radius'], RADIUS_RANGE, 'm')
    if frequency is not None:
        frequency = _parse_number(f'{where}: frequency', frequency, FREQUENCY_RANGE, 'Hz')
    return Beacon(id_, (x, y, z), radius, frequency)


def _parse_number(field: str, value: object, limits: tuple[float, float], unit: str) -> float:
    if isinstance(value, bool) or not isinstance(value, int | float) or str(value) == 'nan':
        raise BeaconsFileError(f'{field} is {value!r}, not a number; write it like 0.01')
    low, high = limits
    if not low <= value <= high:
        held = f'{value:g}' if isinstance(value, float) or abs(value) < _HUGE else 'a huge number'
        remedy = f'it must be between {low:g} and {high:g}; is it in {unit}?'
        raise BeaconsFileError(f'{field} is {held} {unit}, {remedy}')
    return float(value)


def _check_duplicates(path: Path, beacons: list[Beacon]) -> None:
    counts = Counter(beacon.id for beacon in beacons)
    for id_ in sorted(counts):
        if counts[id_] > 1:
            raise BeaconsFileError(f'{path}: id {id_} is used {counts[id_]} times; give each lamp its own')
    for k, beacon in enumerate(beacons):
        for other in beacons[:k]:
            if math.dist(beacon.xyz, other.xyz) < SEPARATION_MIN:
                names = f'{other.id} and {beacon.id}'
                raise BeaconsFileError(f'{path}: beacons {names} have the same xyz; correct one of them')
