"""Makes a settings instance from values by name, as parameters, files and options give them."""

from __future__ import annotations

import dataclasses
from collections.abc import Mapping
from difflib import get_close_matches
from numbers import Real
from typing import Any, TypeVar, get_type_hints

from shirube_settings.check import check_value
from shirube_settings.definition import SettingDescription, describe_settings
from shirube_settings.settings_error import SettingsError

Settings = TypeVar('Settings')


def settings_from_values(cls: type[Settings], values: Mapping[str, Any]) -> Settings:
    """Return the settings with the given values and defaults for the rest, checked.

    Args:
        cls: a settings dataclass.
        values: value by setting name (``group.name`` in a nested class). A list is taken for a tuple and a
            whole number for a float.

    Raises:
        SettingsError: a value of a wrong type or out of range, or a name that does not exist.
    """
    descriptions = {description.name: description for description in describe_settings(cls)}
    converted = {}
    for name, value in values.items():
        if name not in descriptions:
            raise SettingsError(_unknown_name_message(name, list(descriptions)))
        converted[name] = _converted(descriptions[name], value)
        check_value(descriptions[name], converted[name])
    settings: Settings = _filled(cls(), converted, '')
    return settings


def _converted(description: SettingDescription, value: Any) -> Any:
    if description.is_tuple and isinstance(value, (list, tuple)):
        return tuple(_as_float(element) for element in value)
    return _as_float(value) if description.type is float else value


def _as_float(value: Any) -> Any:
    return float(value) if isinstance(value, Real) and not isinstance(value, bool) else value


def _filled(defaults: Any, values: Mapping[str, Any], prefix: str) -> Any:
    hints = get_type_hints(type(defaults))
    changes: dict[str, Any] = {}
    for field in dataclasses.fields(defaults):
        name = prefix + field.name
        if dataclasses.is_dataclass(hints[field.name]):
            changes[field.name] = _filled(getattr(defaults, field.name), values, f'{name}.')
        elif name in values:
            changes[field.name] = values[name]
    return dataclasses.replace(defaults, **changes)


def _unknown_name_message(name: str, names: list[str]) -> str:
    close = get_close_matches(name, names, n=1)
    remedy = f'did you mean {close[0]}?' if close else f'there are {", ".join(names)}'
    return f'setting {name} does not exist, {remedy}'
