"""Validates the fields of requests from the browser."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

from stereo_landmark.core.procedure.primitive import PrimitiveKind
from stereo_landmark.core.stereo_landmark_error import StereoLandmarkError

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
