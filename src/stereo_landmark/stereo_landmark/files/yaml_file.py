"""Reads YAML files that users edit, with validation against a JSON Schema and one-line error messages."""

import json
from collections.abc import Iterable
from difflib import get_close_matches
from functools import cache
from importlib.resources import files
from pathlib import Path
from typing import Any

from jsonschema import Draft202012Validator, ValidationError
from jsonschema.exceptions import best_match, relevance

import shirube_core.files
from stereo_landmark.core.stereo_landmark_error import StereoLandmarkError

_NUMBER_MAX = 1e30
"""Maximum absolute value; squares and products of smaller numbers are finite."""
_BYTES_MAX = 1 << 24  # a place with many targets is long


class LandmarkFileError(StereoLandmarkError):
    """A file is missing or malformed; the one-line message names file, field and remedy."""


def read_yaml(path: Path, remedy: str) -> dict[str, Any]:
    """Return the fields of a YAML file, with only finite numbers.

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


_LENGTH_MAX = 60
"""Maximum length of a quoted value [characters]."""
_TYPE_NAMES = {
    'object': 'fields',
    'array': 'a list',
    'string': 'a text',
    'integer': 'a whole number',
    'null': 'nothing',
}
_CONSTRAINTS = {
    'enum': 'be one of {}',
    'const': 'be {}',
    'minItems': 'have at least {} entries',
    'maxItems': 'have at most {} entries',
    'minimum': 'be at least {}',
    'exclusiveMinimum': 'be above {}',
    'maximum': 'be at most {}',
}
"""Message for each schema keyword."""


def check_schema(content: object, schema: str, where: str, remedy: str) -> None:
    """Check content against a schema.

    Args:
        content: content of a file.
        schema: name of the schema file ``<name>.json`` in this package.
        where: name of the file, for the message.
        remedy: remedy that ends the message, unless the error has its own.

    Raises:
        LandmarkFileError: the content is invalid; the message names file, field and remedy.
    """
    fault = best_match(_validator(schema).iter_errors(content), key=_error_relevance)
    if fault is not None:
        raise LandmarkFileError(f'{where}: {_error_message(fault, remedy)}')


@cache
def _validator(schema: str) -> Draft202012Validator:
    text = files('stereo_landmark.files').joinpath(f'{schema}.json').read_text(encoding='utf-8')
    return Draft202012Validator(json.loads(text))


def _error_relevance(fault: ValidationError) -> tuple[Any, bool]:
    """Sort key of errors: a misspelled field ranks before the missing field at the same level."""
    return relevance(fault), fault.validator == 'additionalProperties'


def _error_message(fault: ValidationError, remedy: str) -> str:
    field = _field_path(fault.absolute_path)
    match fault.validator:
        case 'additionalProperties':
            known = list(fault.schema.get('properties', {}))
            unknown = next(str(name) for name in fault.instance if name not in known)
            close = get_close_matches(unknown, known, n=1)
            hint = f'did you mean {close[0]}?' if close else f'there are {", ".join(known)}'
            return f'{_join_field(field, unknown)} does not exist, {hint}'
        case 'required':
            missing = next(name for name in fault.validator_value if name not in fault.instance)
            return f'{_join_field(field, missing)} is missing; {remedy}'
        case _:
            value = repr(fault.instance)
            short = value if len(value) <= _LENGTH_MAX else f'{value[:_LENGTH_MAX]} …'
            return f'{field or "the content"} is {short}, {_expected_value(fault)}; {remedy}'


def _expected_value(fault: ValidationError) -> str:
    """Return the requirement of a schema as text."""
    expected: Any = fault.validator_value
    if fault.validator == 'type':
        kinds = expected if isinstance(expected, list) else [expected]
        return 'it must be ' + ' or '.join(_TYPE_NAMES.get(kind, f'a {kind}') for kind in kinds)
    if fault.validator == 'enum':
        expected = ', '.join(map(str, expected))
    return f'it must {_CONSTRAINTS.get(str(fault.validator), "match {}").format(expected)}'


def _field_path(path: Iterable[str | int]) -> str:
    field = ''
    for part in path:
        field = f'{field}[{part}]' if isinstance(part, int) else _join_field(field, part)
    return field


def _join_field(field: str, name: str) -> str:
    return f'{field}.{name}' if field else name
