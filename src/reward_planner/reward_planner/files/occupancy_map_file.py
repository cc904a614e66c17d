"""map_server maps: a YAML file and an image (PGM, PNG or BMP), whose first line is the map's highest row.

Pixels become cells as in map_io.cpp of Nav2 (Jazzy).
"""

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
    turned_map,
)
from reward_planner.core.reward_planner_error import RewardPlannerError
from shirube_core.files import YamlFileError, atomic_write, format_value, is_number, read_yaml, write_text

_MODES = ('trinary', 'scale', 'raw')
# Free, unknown and occupied. map_saver's 205 for unknown would be read as free with its threshold of 0.25.
_WHITE, _GREY, _BLACK = 254, 128, 0
_RAW_UNKNOWN = 255
_NAME_MAX = 1000  # longest path of an image
_ORIGIN_MAX = 1e8  # largest coordinate of an origin [m]
_REQUIRED_FIELDS = ('image', 'resolution', 'origin', 'occupied_thresh', 'free_thresh')
_SEPARATOR = rb'(?:\s|#[^\n]*\n)+'
_PGM_HEADER = re.compile(rb'P5' + _SEPARATOR + rb'(\d+)' + _SEPARATOR + rb'(\d+)' + _SEPARATOR + rb'(\d+)\s')
_PNG = b'\x89PNG'  # others have no alpha channel; a fourth byte of BMP may be padding
_YAML = ('.yaml', '.yml')


def load_occupancy_map(path: Path, resolution: float | None = None) -> OccupancyMap:
    """Load a map from a YAML file and its image; ``resolution`` is a required one [m].

    A map whose origin has a yaw is turned into cells along x and y of the map frame.

    Raises:
        RewardPlannerError: a file is missing or corrupted, a field is missing or invalid, or the resolution differs.
    """
    fields = _read_fields(path)
    side = _number(path, fields, 'resolution', 1e-6, 1e3)
    if resolution is not None and not math.isclose(side, resolution, rel_tol=1e-6):
        raise RewardPlannerError(
            f'{path}: resolution is {side:g} m, it must be {resolution:g} m; give a map of that resolution'
        )
    x, y, yaw = _read_origin(path, fields['origin'])
    cells = _occupancy_of(path, fields, *_read_image(path.parent / fields['image']))
    if yaw:
        return turned_map(cells, side, (x, y, yaw))
    rows, columns = cells.shape
    return OccupancyMap(GridFrame(x, y, side, columns, rows), cells)


def save_occupancy_map(path: Path, grid: OccupancyMap) -> None:
    """Write a map as a YAML file and a PGM file of the same name, each atomically; `load_occupancy_map` reads it back.

    The mode is trinary if all cells are occupied (100), free (0) or unknown, else raw.

    Raises:
        RewardPlannerError: the name does not end with .yaml or .yml.
        OSError: the file cannot be written.
    """
    check_yaml_suffix(path)
    image = path.with_suffix('.pgm')
    cells = grid.occupancy
    occupied, free = cells == OCCUPIED, cells == FREE
    is_trinary = bool((occupied | free | (cells == UNKNOWN)).all())
    if is_trinary:
        pixels = np.select([occupied, free], [_BLACK, _WHITE], _GREY).astype(np.uint8)
    else:
        pixels = np.where(cells == UNKNOWN, _RAW_UNKNOWN, cells).astype(np.uint8)
    with atomic_write(image) as file:
        file.write(f'P5\n{grid.frame.columns} {grid.frame.rows}\n255\n'.encode())
        file.write(pixels[::-1].tobytes())
    fields = {
        'image': image.name,
        'mode': 'trinary' if is_trinary else 'raw',
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
        ('mode', mode, mode in _MODES, 'trinary, scale or raw'),
        ('negate', negate, negate in (0, 1), '0 or 1'),
        ('image', image, is_name, 'the name of a PGM, PNG or BMP file'),
    ):
        if not is_valid:
            raise _invalid(path, name, value, needed)
    return fields


def _read_origin(path: Path, origin: object) -> tuple[float, float, float]:
    if not isinstance(origin, list) or len(origin) != 3 or not all(is_number(value) for value in origin):
        raise _invalid(path, 'origin', origin, '[x, y, yaw]')
    if max(abs(origin[0]), abs(origin[1])) > _ORIGIN_MAX:
        raise _invalid(path, 'origin', origin, f'within {_ORIGIN_MAX:g} m')
    return float(origin[0]), float(origin[1]), math.remainder(origin[2], math.tau)


def _number(path: Path, fields: dict[str, Any], name: str, low: float, high: float) -> float:
    value = fields[name]
    if not is_number(value) or not low <= value <= high:
        raise _invalid(path, name, value, f'a number from {low:g} to {high:g}')
    return float(value)


def _invalid(path: Path, name: str, value: object, needed: str) -> RewardPlannerError:
    return RewardPlannerError(f'{path}: {name} is {format_value(value)}, it must be {needed}')


def _occupancy_of(
    path: Path, fields: dict[str, Any], pixels: NDArray[np.uint8], is_transparent: NDArray[np.bool_]
) -> NDArray[np.int8]:
    """Return the map's cells, lowest row first."""
    mode = fields.get('mode', 'trinary')
    if mode == 'raw':
        return np.where(pixels <= OCCUPIED, pixels, UNKNOWN).astype(np.int8)[::-1]
    occupied_from = _number(path, fields, 'occupied_thresh', 0.0, 1.0)
    free_up_to = _number(path, fields, 'free_thresh', 0.0, occupied_from)
    # Single precision, as in Nav2, decides alike where a grey value is at a threshold.
    brightness = pixels.astype(np.float32) / 255.0
    occupancy = brightness if fields.get('negate', 0) else 1.0 - brightness
    between = np.full(pixels.shape, float(UNKNOWN))
    if mode == 'scale' and occupied_from > free_up_to:
        between = np.floor((occupancy - free_up_to) / (occupied_from - free_up_to) * OCCUPIED + 0.5)
    cells = np.select(
        [is_transparent, occupancy <= free_up_to, occupancy >= occupied_from], [UNKNOWN, FREE, OCCUPIED], between
    )
    return cells.astype(np.int8)[::-1]


def _read_image(path: Path) -> tuple[NDArray[np.uint8], NDArray[np.bool_]]:
    """Return the grey values of an image and which pixels are not opaque, shape (rows, columns), first line first."""
    try:
        data = path.read_bytes()
    except OSError as fault:
        raise RewardPlannerError(
            f'{path}: cannot be read ({fault.strerror}); put the image into the folder of its YAML file'
        ) from fault
    header = _PGM_HEADER.match(data)
    if header:
        _check_size(path, data, header)
    encoded = np.frombuffer(data, dtype=np.uint8)
    try:
        pixels = cv2.imdecode(encoded, cv2.IMREAD_GRAYSCALE | cv2.IMREAD_IGNORE_ORIENTATION)
        raw = cv2.imdecode(encoded, cv2.IMREAD_UNCHANGED)
    except cv2.error:  # also of an empty file
        pixels = raw = None
    if pixels is None or raw is None:
        raise RewardPlannerError(f'{path}: is not an image or is corrupted; give a PGM, PNG or BMP file')
    is_transparent = np.zeros(pixels.shape, dtype=np.bool_)
    if data.startswith(_PNG) and raw.ndim == 3 and raw.shape[2] == 4:
        is_transparent = raw[..., 3] < np.iinfo(raw.dtype).max
    return np.asarray(pixels, dtype=np.uint8), is_transparent


def _check_size(path: Path, data: bytes, header: re.Match[bytes]) -> None:
    """Check that a PGM is not truncated; readers would fill up missing cells."""
    columns, rows, white = (int(number) for number in header.groups())
    actual, needed = len(data) - header.end(), rows * columns * (2 if white > 255 else 1)
    if not needed <= actual <= needed + 1:  # some writers append a line feed
        raise RewardPlannerError(
            f'{path}: has {actual} bytes, {columns} x {rows} cells need {needed}; save the map again'
        )
