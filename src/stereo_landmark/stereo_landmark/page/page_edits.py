"""Edit commands of the page, and the fields of its requests."""

import math
from collections.abc import Callable, Mapping
from typing import Any

from shirube_core.geometry import SE2
from stereo_landmark.core.primitives.primitive import PrimitiveKind
from stereo_landmark.core.stereo_landmark_error import StereoLandmarkError
from stereo_landmark.core.teaching import edits
from stereo_landmark.core.teaching.edits import TeachingState
from stereo_landmark.core.teaching.primitive_selection import Region

Request = Mapping[str, Any]

NUMBER_MAX = 1e12
"""Maximum absolute value of a number in m, rad or px; squares of such numbers are finite."""
TILT_MAX = math.radians(45.0)
"""Maximum roll and pitch of a test image [rad]."""


def text(request: Request, name: str) -> str:
    """Return a string field; StereoLandmarkError if it is none."""
    return str(_field(request, name, 'a string', lambda value: isinstance(value, str)))


def number(request: Request, name: str) -> float:
    """Return a number field with an absolute value less than `NUMBER_MAX`; StereoLandmarkError if it is none."""
    value = _field(request, name, 'a number', _is_number)
    return float(value)


def integer(request: Request, name: str) -> int:
    """Return an integer field; StereoLandmarkError if it is none."""
    return int(_field(request, name, 'an integer', lambda value: isinstance(value, int) and not _is_flag(value)))


def flag(request: Request, name: str) -> bool:
    """Return a boolean field; StereoLandmarkError if it is none."""
    return bool(_field(request, name, 'true or false', _is_flag))


def sides(request: Request) -> list[str]:
    """Return the requested sides of the stereo pair; StereoLandmarkError if there are others."""
    _text_list(request, 'sides')
    return list(_field(request, 'sides', 'left or right', lambda values: {*values} <= {'left', 'right'}))


def kind(request: Request) -> PrimitiveKind:
    """Return the kind of a primitive; StereoLandmarkError if it is none."""
    kinds = [each.value for each in PrimitiveKind]
    text(request, 'kind')
    return PrimitiveKind(_field(request, 'kind', ' or '.join(kinds), lambda value: value in kinds))


def _text_list(request: Request, name: str) -> list[str]:
    def is_valid(values: Any) -> bool:
        return isinstance(values, list) and all(isinstance(value, str) for value in values)

    return list(_field(request, name, 'a list of strings', is_valid))


def _is_flag(value: Any) -> bool:
    return isinstance(value, bool)


def _is_number(value: Any) -> bool:
    return isinstance(value, int | float) and not _is_flag(value) and abs(value) < NUMBER_MAX


def _field(request: Request, name: str, expected: str, is_valid: Callable[[Any], bool]) -> Any:
    value = request.get(name)
    if not is_valid(value):
        raise StereoLandmarkError(f'request: {name} must be {expected}; reload the page')
    return value


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
    def is_valid(values: Any) -> bool:
        return isinstance(values, list) and len(values) == count

    values = _field(request, name, f'{count} numbers', is_valid)
    return [number({name: value}, name) for value in values]


def tilt(request: Request) -> tuple[float, float] | None:
    """Return roll and pitch [rad], None if they are not given; StereoLandmarkError if they are no small angles."""
    if request.get('tilt') is None:
        return None
    roll, pitch = _numbers(request, 'tilt', 2)
    if max(abs(roll), abs(pitch)) > TILT_MAX:
        raise StereoLandmarkError(f'roll and pitch must be within ± {math.degrees(TILT_MAX):.0f}°; correct them')
    return roll, pitch


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
    'set_points_used': lambda state, r: edits.set_points_used(state, _text_list(r, 'points'), used=flag(r, 'used')),
}
"""Edits by the value of the field ``do``; each may raise a StereoLandmarkError."""
