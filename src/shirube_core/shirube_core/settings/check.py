"""Validates settings against their definitions."""

from __future__ import annotations

import math
from functools import reduce
from numbers import Integral, Real

from shirube_core.settings.definition import SettingDescription, SettingsError, describe_settings


def check_settings(settings: object) -> None:
    """Check types, ranges and choices of every value, including nested ones.

    Args:
        settings: instance of a settings dataclass.

    Raises:
        SettingsError: one line that names the setting, its value and what is allowed.
    """
    for description in describe_settings(type(settings)):
        check_value(description, reduce(getattr, description.name.split('.'), settings))


def check_value(description: SettingDescription, value: object) -> None:
    """Check one value against its description.

    Raises:
        SettingsError: one line that names the setting, its value and what is allowed.
    """
    if not _has_type(description, value):
        raise SettingsError(
            f'setting {description.name} is {value!r}, it must be {_describe_type(description)}'
        )
    numbers = value if isinstance(value, tuple) else (value,)
    if not all(_is_allowed(description, number) for number in numbers):
        unit = f' {description.unit}' if description.unit else ''
        raise SettingsError(
            f'setting {description.name} is {value!r}{unit}, allowed is {_describe_limits(description)}'
            f' ({description.description})'
        )


def _has_type(description: SettingDescription, value: object) -> bool:
    if description.is_tuple:
        right_length = description.length is None or (
            isinstance(value, tuple) and len(value) == description.length
        )
        return isinstance(value, tuple) and right_length and all(_is_number(element) for element in value)
    if description.type is float:
        return _is_number(value)
    if description.type is int:
        return isinstance(value, Integral) and not isinstance(value, bool)
    return bool(isinstance(value, description.type))


def _is_number(value: object) -> bool:
    return isinstance(value, Real) and not isinstance(value, bool)


def _is_allowed(description: SettingDescription, value: object) -> bool:
    if description.choices and value not in description.choices:
        return False
    if not isinstance(value, Real):
        return True
    above = description.minimum is None or float(value) >= description.minimum
    below = description.maximum is None or float(value) <= description.maximum
    return math.isfinite(value) and above and below


def _describe_type(description: SettingDescription) -> str:
    if description.is_tuple:
        return 'numbers' if description.length is None else f'{description.length} numbers'
    descriptions = {float: 'a number', int: 'a whole number', bool: 'true or false', str: 'a text'}
    return descriptions[description.type]


def _describe_limits(description: SettingDescription) -> str:
    return 'any finite number' if description.limits == 'any' else description.limits
