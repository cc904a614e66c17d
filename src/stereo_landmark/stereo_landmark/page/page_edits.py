"""Edit commands of the page, and the fields of its requests."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from typing import Any

from shirube_core.geometry import SE2
from stereo_landmark.core.primitives.primitive import PrimitiveKind
from stereo_landmark.core.stereo_landmark_error import StereoLandmarkError
from stereo_landmark.core.teaching import edits
from stereo_landmark.core.teaching.primitive_selection import Region
from stereo_landmark.core.teaching.teaching_state import TeachingState

Request = Mapping[str, Any]

NUMBER_MAX = 1e12
"""Maximum absolute value of a number in m, rad or px; squares of such numbers are finite."""


def text(request: Request, name: str) -> str:
    """Return a string field.

    Raises:
        StereoLandmarkError: it is missing or not a string.
    """
    value = request.get(name)
    if not isinstance(value, str):
        raise _field_error(name, 'a string')
    return value


def number(request: Request, name: str) -> float:
    """Return a number field with an absolute value less than `NUMBER_MAX`.

    Raises:
        StereoLandmarkError: it is missing or not such a number.
    """
    value = request.get(name)
    if isinstance(value, bool) or not isinstance(value, int | float) or not abs(value) < NUMBER_MAX:
        raise _field_error(name, 'a number')
    return float(value)


def integer(request: Request, name: str) -> int:
    """Return an integer field.

    Raises:
        StereoLandmarkError: it is missing or not an integer.
    """
    value = request.get(name)
    if isinstance(value, bool) or not isinstance(value, int):
        raise _field_error(name, 'an integer')
    return value


def flag(request: Request, name: str) -> bool:
    """Return a boolean field.

    Raises:
        StereoLandmarkError: it is missing or not a boolean.
    """
    value = request.get(name)
    if not isinstance(value, bool):
        raise _field_error(name, 'true or false')
    return value


def text_list(request: Request, name: str) -> list[str]:
    """Return a field with a list of strings.

    Raises:
        StereoLandmarkError: it is missing or not a list of strings.
    """
    values = request.get(name)
    if not isinstance(values, list) or not all(isinstance(value, str) for value in values):
        raise _field_error(name, 'a list of strings')
    return values


def sides(request: Request) -> list[str]:
    """Return the requested sides of the stereo pair.

    Raises:
        StereoLandmarkError: it is missing, or contains values other than left and right.
    """
    values = text_list(request, 'sides')
    if not set(values) <= {'left', 'right'}:
        raise _field_error('sides', 'left or right')
    return values


def kind(request: Request) -> PrimitiveKind:
    """Return the kind of a primitive.

    Raises:
        StereoLandmarkError: it is missing or not a kind.
    """
    try:
        return PrimitiveKind(text(request, 'kind'))
    except ValueError as fault:
        raise _field_error('kind', ' or '.join(each.value for each in PrimitiveKind)) from fault


def _field_error(name: str, expected: str) -> StereoLandmarkError:
    return StereoLandmarkError(f'request: {name} must be {expected}; reload the page')


def _pose(request: Request) -> SE2 | None:
    if request.get('pose') is None:
        return None
    x, y, yaw = _numbers(request, 'pose', 3)
    return SE2(x, y, yaw)


def _region(request: Request) -> Region | None:
    if request.get('region') is None:
        return None
    return Region(*_numbers(request, 'region', 4))


def _numbers(request: Request, name: str, count: int) -> list[float]:
    values = request[name]
    if not isinstance(values, list) or len(values) != count:
        raise StereoLandmarkError(f'request: {name} must be {count} numbers; reload the page')
    return [number({name: value}, name) for value in values]


Edit = Callable[[TeachingState, Request], TeachingState]

EDITS: dict[str, Edit] = {
    'rename_place': lambda state, r: edits.rename_place(state, text(r, 'name')),
    'set_map_pose': lambda state, r: edits.set_map_pose(state, _pose(r)),
    'set': lambda state, r: edits.set_processing(state, text(r, 'name'), number(r, 'value')),
    'reset': lambda state, r: edits.reset_processing(state, text(r, 'group')),
    'show_kind': lambda state, r: edits.show_kind(state, kind(r), shown=flag(r, 'shown')),
    'add_target': lambda state, _: edits.add_target(state),
    'remove_target': lambda state, r: edits.remove_target(state, integer(r, 'target')),
    'activate_target': lambda state, r: edits.activate_target(state, integer(r, 'target')),
    'rename_target': lambda state, r: edits.rename_target(state, integer(r, 'target'), text(r, 'name')),
    'set_region': lambda state, r: edits.set_region(state, _region(r)),
    'drop': lambda state, r: edits.remove_primitive(state, text(r, 'name')),
    'rename_primitive': lambda state, r: edits.rename_primitive(state, text(r, 'name'), text(r, 'to')),
    'move': lambda state, r: edits.move_primitive(state, text(r, 'name'), integer(r, 'place')),
    'set_points_used': lambda state, r: edits.set_points_used(
        state, text_list(r, 'points'), used=flag(r, 'used')
    ),
}
"""Edits by the value of the field ``do``; each may raise a StereoLandmarkError."""
