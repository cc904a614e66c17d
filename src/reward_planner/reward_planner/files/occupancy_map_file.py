"""map_server maps: a YAML file and an image (PGM or PNG), whose first line is the map's highest row."""

from __future__ import annotations

import math
import re
from pathlib import Path
from typing import Any

import cv2
import numpy as np
import yaml
from numpy.typing import NDArray

from reward_planner.core.occupancy_map import (
    FREE,
    FREE_THRESHOLD,
    OCCUPIED,
    OCCUPIED_THRESHOLD,
    UNKNOWN,
    GridFrame,
    OccupancyMap,
)
from reward_planner.core.reward_planner_error import RewardPlannerError
from shirube_core.files import YamlFileError, atomic_write, format_value, is_number, read_yaml, write_text

# Free, unknown and occupied. map_saver's 205 for unknown would be read as free with its threshold of 0.25.
_WHITE, _GREY, _BLACK = 254, 128, 0
_NAME_MAX = 1000  # longest path of an image
_ORIGIN_MAX = 1e8  # largest coordinate of an origin [m]
_REQUIRED_FIELDS = ('image', 'resolution', 'origin', 'occupied_thresh', 'free_thresh')
_SEPARATOR = rb'(?:\s|#[^\n]*\n)+'
_PGM_HEADER = re.compile(rb'P5' + _SEPARATOR + rb'(\d+)' + _SEPARATOR + rb'(\d+)' + _SEPARATOR + rb'(\d+)\s')
_YAML = ('.yaml', '.yml')


def load_occupancy_map(path: Path, resolution: float | None = None) -> OccupancyMap:
    """Load a map from a YAML file and its image; ``resolution`` is a required one [m].

    Raises:
        RewardPlannerError: a file is missing or corrupted, a field is missing or invalid, or the resolution differs.
    """
    fields = _read_fields(path)
    side = _number(path, fields, 'resolution', 1e-6, 1e3)
    if resolution is not None and not math.isclose(side, resolution, rel_tol=1e-6):
        raise RewardPlannerError(
            f'{path}: resolution is {side:g} m, it must be {resolution:g} m; give a map of that resolution'
        )
    origin_x, origin_y = _read_origin(path, fields['origin'])
    pixels = _read_image(path.parent / fields['image'])
    rows, columns = pixels.shape
    frame = GridFrame(origin_x, origin_y, side, columns, rows)
    return OccupancyMap(frame, _occupancy_of(path, fields, pixels))


def save_occupancy_map(path: Path, grid: OccupancyMap) -> None:
    """Write a map as a YAML file and a PGM file of the same name, each atomically.

    Raises:
        RewardPlannerError: the name does not end with .yaml or .yml.
        OSError: the file cannot be written.
    """
    check_yaml_suffix(path)
    image = path.with_suffix('.pgm')
    occupied, free = grid.occupied(), (grid.occupancy >= 0) & (grid.occupancy < FREE_THRESHOLD)
    pixels = np.select([occupied, free], [_BLACK, _WHITE], _GREY).astype(np.uint8)
    with atomic_write(image) as file:
        file.write(f'P5\n{grid.frame.columns} {grid.frame.rows}\n255\n'.encode())
        file.write(pixels[::-1].tobytes())
    fields = {
        'image': image.name,
        'mode': 'trinary',
        'resolution': grid.frame.resolution,
        'origin': [grid.frame.origin_x, grid.frame.origin_y, 0.0],
        'negate': 0,
        'occupied_thresh': OCCUPIED_THRESHOLD / 100,
        'free_thresh': FREE_THRESHOLD / 100,
    }
    write_text(path, yaml.safe_dump(fields, sort_keys=False))


def check_yaml_suffix(path: Path) -> None:
    """Raise a RewardPlannerError if a map's file does not end with .yaml or .yml, unlike its image."""
    if path.suffix not in _YAML:
        raise RewardPlannerError(f'{path}: is not a name for the YAML file of a map; it must end with .yaml')


def _read_fields(path: Path) -> dict[str, Any]:
    try:
        fields = read_yaml(path)
    except YamlFileError as fault:
        raise RewardPlannerError(f'{fault}; give the YAML file of a map') from fault
    missing = [name for name in _REQUIRED_FIELDS if name not in fields]
    if missing:
        raise RewardPlannerError(f'{path}: {missing[0]} is missing; a map has {", ".join(_REQUIRED_FIELDS)}')
    image, mode, negate = fields['image'], fields.get('mode', 'trinary'), fields.get('negate', 0)
    is_name = isinstance(image, str) and 0 < len(image) <= _NAME_MAX and '\0' not in image
    for name, value, is_valid, needed in (
        ('mode', mode, mode == 'trinary', 'trinary; save the map with mode trinary'),
        ('negate', negate, negate in (0, 1), '0 or 1'),
        ('image', image, is_name, 'the name of a PGM or PNG file'),
    ):
        if not is_valid:
            raise _invalid(path, name, value, needed)
    return fields


def _read_origin(path: Path, origin: object) -> tuple[float, float]:
    if not isinstance(origin, list) or len(origin) != 3 or not all(is_number(value) for value in origin):
        raise _invalid(path, 'origin', origin, '[x, y, yaw]')
    if origin[2] != 0:
        raise RewardPlannerError(
            f'{path}: origin has a yaw of {origin[2]} rad, it must be 0; save the map with a yaw of 0'
        )
    if max(abs(origin[0]), abs(origin[1])) > _ORIGIN_MAX:
        raise _invalid(path, 'origin', origin, f'within {_ORIGIN_MAX:g} m')
    return float(origin[0]), float(origin[1])


def _number(path: Path, fields: dict[str, Any], name: str, low: float, high: float) -> float:
    value = fields[name]
    if not is_number(value) or not low <= value <= high:
        raise _invalid(path, name, value, f'a number from {low:g} to {high:g}')
    return float(value)


def _invalid(path: Path, name: str, value: object, needed: str) -> RewardPlannerError:
    return RewardPlannerError(f'{path}: {name} is {format_value(value)}, it must be {needed}')


def _occupancy_of(path: Path, fields: dict[str, Any], pixels: NDArray[np.uint8]) -> NDArray[np.int8]:
    """Return the map's cells, lowest row first."""
    occupied_from = _number(path, fields, 'occupied_thresh', 0.0, 1.0)
    free_below = _number(path, fields, 'free_thresh', 0.0, occupied_from)
    brightness = pixels[::-1] / 255.0
    occupancy = brightness if fields.get('negate', 0) else 1.0 - brightness
    cells = np.select([occupancy > occupied_from, occupancy < free_below], [OCCUPIED, FREE], UNKNOWN)
    return cells.astype(np.int8)


def _read_image(path: Path) -> NDArray[np.uint8]:
    """Return the grey values of an image, shape (rows, columns), first line first."""
    try:
        data = path.read_bytes()
    except OSError as fault:
        raise RewardPlannerError(
            f'{path}: cannot be read ({fault.strerror}); put the image into the folder of its YAML file'
        ) from fault
    header = _PGM_HEADER.match(data)
    if header:
        _check_size(path, data, header)
    try:
        pixels = cv2.imdecode(np.frombuffer(data, dtype=np.uint8), cv2.IMREAD_GRAYSCALE) if data else None
    except cv2.error:
        pixels = None
    if pixels is None:
        raise RewardPlannerError(f'{path}: is not an image or is corrupted; give a PGM or PNG file')
    return np.asarray(pixels, dtype=np.uint8)


def _check_size(path: Path, data: bytes, header: re.Match[bytes]) -> None:
    """Check that a PGM is not truncated; readers would fill up missing cells."""
    columns, rows, white = (int(number) for number in header.groups())
    actual, needed = len(data) - header.end(), rows * columns * (2 if white > 255 else 1)
    if not needed <= actual <= needed + 1:  # some writers append a line feed
        raise RewardPlannerError(
            f'{path}: has {actual} bytes, {columns} x {rows} cells need {needed}; save the map again'
        )
