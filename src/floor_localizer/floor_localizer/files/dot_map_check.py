"""Validation of dot maps: finite numbers, plausible units, enough dots, no duplicates."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
from numpy.typing import NDArray

from floor_localizer.core.constellation.dot_grid import typical_spacing
from floor_localizer.core.dot_map import DotMap
from floor_localizer.files.file_errors import DotMapError

MIN_DOTS = 20
# Maximum distance of duplicates; touching chips have centres a millimetre apart [m].
_SAME_PLACE = 1e-5
# Maximum plausible spacing: to see twenty such dots, a camera must be higher than any robot's belly [m].
_WIDEST_SPACING = 0.2
_LARGEST_DIAMETER = 0.1
# Maps in millimetres have values above these, maps in centimetres below.
_SPACING_IN_MILLIMETRES, _DIAMETER_IN_MILLIMETRES = 4.0, 0.8


def check_dot_map(dot_map: DotMap, source: str, locate: Callable[[int], str]) -> None:
    """Check that a map is a valid map of dots in metres.

    Args:
        dot_map: the map; NaN diameters are unknown.
        source: name of the file, for the message.
        locate: returns the location of a dot in the file, such as ``line 7``.

    Raises:
        DotMapError: numbers that are not finite, diameters that are not positive, too few dots, duplicates, or a unit
            other than metres.
    """
    check_dot_count(len(dot_map), source)
    check_dots(dot_map.points, dot_map.diameters, source, locate)
    known = dot_map.diameters[np.isfinite(dot_map.diameters)]
    diameter = float(np.median(known)) if len(known) else 0.0
    check_units(diameter, typical_spacing(dot_map.points), source)
    duplicates = find_duplicates(dot_map.points, dot_map.points.min(axis=0))
    if duplicates is not None:
        raise DotMapError(
            f'{source}, {locate(duplicates[1])}: is the same dot as {locate(duplicates[0])}; leave one of the two out'
        )


def check_dot_count(dots: int, source: str) -> None:
    """Check that a map has enough dots."""
    if dots < MIN_DOTS:
        raise DotMapError(
            f'{source}: has {dots} dots, at least {MIN_DOTS} are needed; survey more of the floor'
        )


def check_dots(
    points: NDArray[np.float64], diameters: NDArray[np.float64], source: str, locate: Callable[[int], str]
) -> None:
    """Check each dot on its own: coordinates and diameter.

    Args:
        points: shape (n, 2), dots [m].
        diameters: shape (n,), diameters [m], NaN if unknown.
        source: name of the file, for the message.
        locate: returns the location of a dot in the file, such as ``line 7``.

    Raises:
        DotMapError: numbers that are not finite, diameters that are not positive.
    """
    for name, column in (('x', points[:, 0]), ('y', points[:, 1])):
        if not np.isfinite(column).all():
            where = locate(_first(~np.isfinite(column)))
            raise DotMapError(f'{source}, {where}: {name} is not finite; give metres or leave the dot out')
    wrong = (diameters <= 0.0) | np.isinf(diameters)
    if wrong.any():
        dot = _first(wrong)
        raise DotMapError(
            f'{source}, {locate(dot)}: diameter is {diameters[dot]:g}, it must be positive; '
            'leave it empty where it is unknown'
        )


def _first(mask: NDArray[np.bool_]) -> int:
    return int(np.flatnonzero(mask)[0])


def check_units(diameter: float, spacing: float, source: str) -> None:
    """Check that a map is in metres, by the median diameter (0 if unknown) and the spacing of its dots [m]."""
    if diameter > _LARGEST_DIAMETER:
        sign, is_millimetres = f'diameters of {diameter:.3g} m', diameter > _DIAMETER_IN_MILLIMETRES
    elif spacing > _WIDEST_SPACING:
        sign, is_millimetres = f'dots {spacing:.3g} m apart', spacing > _SPACING_IN_MILLIMETRES
    else:
        return
    unit, divisor = ('millimetres', 1000) if is_millimetres else ('centimetres', 100)
    raise DotMapError(
        f'{source}: looks like {unit} ({sign}); x, y and diameter must be metres: divide them by {divisor}'
    )


def find_duplicates(points: NDArray[np.float64], lower: NDArray[np.float64]) -> tuple[int, int] | None:
    """Return two dots at the same position, the earlier one first, or None.

    Args:
        points: shape (n, 2), dots [m].
        lower: shape (2,), origin of the quantization [m].
    """
    steps = np.round((points - lower) / _SAME_PLACE).astype(np.int64)
    order = np.lexsort(steps.T)
    duplicates = (np.diff(steps[order], axis=0) == 0).all(axis=1)
    if not duplicates.any():
        return None
    earlier = _first(duplicates)
    return int(order[earlier]), int(order[earlier + 1])
