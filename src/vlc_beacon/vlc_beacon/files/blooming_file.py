"""Blooming calibration file (YAML): ``blooming: {alpha: ..., beta: ..., gamma: ..., beta_sigma: ...}``."""

from __future__ import annotations

import math
from dataclasses import asdict, fields
from pathlib import Path

import yaml

from shirube_core.files import YamlFileError, read_yaml, write_text
from vlc_beacon.core.lamp_image.blooming import BloomingCalibration
from vlc_beacon.core.vlc_beacon_error import VlcBeaconError

_NAMES = tuple(field.name for field in fields(BloomingCalibration))
VALUE_MAX = 1e6
"""Maximum finite value."""
_REMEDY = 'make it with calibrate'


def save_blooming(path: Path, blooming: BloomingCalibration) -> None:
    """Write a calibration atomically.

    Raises:
        OSError: the file cannot be written.
    """
    write_text(path, yaml.safe_dump({'blooming': asdict(blooming)}, sort_keys=False))


def load_blooming(path: Path) -> BloomingCalibration:
    """Load a calibration.

    Raises:
        VlcBeaconError: the file is missing or not YAML, or a field is missing or not a number.
    """
    try:
        entries = read_yaml(path).get('blooming')
    except YamlFileError as error:
        raise VlcBeaconError(f'{error}; {_REMEDY}') from error
    if not isinstance(entries, dict) or set(entries) != set(_NAMES):
        raise VlcBeaconError(f'{path}: blooming must have {", ".join(_NAMES)}; {_REMEDY}')
    for name, value in entries.items():
        if (
            isinstance(value, bool)
            or not isinstance(value, int | float)
            or not (abs(value) <= VALUE_MAX or value == math.inf)
        ):
            raise VlcBeaconError(f'{path}: {name} is {value!r}, not a valid number; {_REMEDY}')
    return BloomingCalibration(**{name: float(entries[name]) for name in _NAMES})
