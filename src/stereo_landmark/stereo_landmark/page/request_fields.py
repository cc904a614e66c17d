"""The fields of what a browser sends, which may be anything."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

from stereo_landmark.core.procedure.primitive import Kind
from stereo_landmark.core.stereo_landmark_error import StereoLandmarkError

Request = Mapping[str, Any]

NUMBER_MAX = 1e12
"""Nothing on the page, in m, rad or px, is larger; squares of such numbers are still finite."""


def text(request: Request, name: str) -> str:
    """Return a text.

    Raises:
        StereoLandmarkError: it is missing or none.
    """
    value = request.get(name)
    if not isinstance(value, str):
        raise _refusal(name, 'a text')
    return value


def number(request: Request, name: str) -> float:
    """Return a finite number, less than `NUMBER_MAX`.

    Raises:
        StereoLandmarkError: it is missing or none.
    """
    value = request.get(name)
    if isinstance(value, bool) or not isinstance(value, int | float) or not abs(value) < NUMBER_MAX:
        raise _refusal(name, 'a number')
    return float(value)


def whole(request: Request, name: str) -> int:
    """Return a whole number.

    Raises:
        StereoLandmarkError: it is missing or none.
    """
    value = request.get(name)
    if isinstance(value, bool) or not isinstance(value, int):
        raise _refusal(name, 'a whole number')
    return value


def flag(request: Request, name: str) -> bool:
    """Return yes or no.

    Raises:
        StereoLandmarkError: it is missing or neither.
    """
    value = request.get(name)
    if not isinstance(value, bool):
        raise _refusal(name, 'true or false')
    return value


def texts(request: Request, name: str) -> list[str]:
    """Return a list of texts.

    Raises:
        StereoLandmarkError: it is missing or none.
    """
    values = request.get(name)
    if not isinstance(values, list) or not all(isinstance(value, str) for value in values):
        raise _refusal(name, 'a list of texts')
    return values


def sides(request: Request) -> list[str]:
    """Return which images of the pair are meant.

    Raises:
        StereoLandmarkError: it is missing, or names another than left or right.
    """
    values = texts(request, 'sides')
    if not set(values) <= {'left', 'right'}:
        raise _refusal('sides', 'left or right')
    return values


def kind(request: Request) -> Kind:
    """Return the kind of a primitive.

    Raises:
        StereoLandmarkError: it is missing or none.
    """
    try:
        return Kind(text(request, 'kind'))
    except ValueError as fault:
        raise _refusal('kind', ' or '.join(each.value for each in Kind)) from fault


def _refusal(name: str, wanted: str) -> StereoLandmarkError:
    return StereoLandmarkError(f'request: {name} must be {wanted}; reload the page')
