"""Reads YAML files that users edit, with validation."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import shirube_core.files
from stereo_landmark.core.stereo_landmark_error import StereoLandmarkError

_NUMBER_MAX = 1e30
"""Maximum absolute value; squares and products of smaller numbers are finite."""
_BYTES_MAX = 1 << 24  # a place with many targets is long


class LandmarkFileError(StereoLandmarkError):
    """A file is missing or malformed; the one-line message names file, field and remedy."""


def read_yaml(path: Path, remedy: str) -> dict[str, Any]:
    """Return the fields of a YAML file, with only finite numbers.

    Args:
        path: path of the file.
        remedy: remedy that ends an error message.

    Raises:
        LandmarkFileError: the file is missing or malformed, or contains no fields or a non-finite number.
    """
    try:
        content = shirube_core.files.read_yaml(path, _BYTES_MAX)
    except shirube_core.files.YamlFileError as fault:
        raise LandmarkFileError(f'{fault}; {remedy}') from fault
    non_finite = find_non_finite(content)
    if non_finite is not None:
        raise LandmarkFileError(f'{path}: {non_finite} is not a finite number; {remedy}')
    return content


def find_non_finite(content: object, field: str = '') -> str | None:
    """Return the field of the first number that is not finite or too large, None if there is none."""
    if isinstance(content, float | int):
        return None if abs(content) < _NUMBER_MAX else field
    parts: list[tuple[str, object]] = []
    if isinstance(content, dict):
        parts = [(f'{field}.{name}'.lstrip('.'), value) for name, value in content.items()]
    elif isinstance(content, list):
        parts = [(f'{field}[{number}]', value) for number, value in enumerate(content)]
    found = (find_non_finite(value, name) for name, value in parts)
    return next((name for name in found if name is not None), None)
