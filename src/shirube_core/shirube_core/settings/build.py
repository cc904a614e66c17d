"""Builds settings from values by name and checks them; former names are rejected with the new one."""

import argparse
import dataclasses
import math
from collections.abc import Collection, Mapping, Sequence
from difflib import get_close_matches
from functools import reduce
from numbers import Integral, Real
from typing import Any, TypeVar, cast, get_type_hints

from shirube_core.settings.definition import SettingDescription, SettingsError, describe_settings

Settings = TypeVar('Settings')


def settings_from_values(cls: type[Settings], values: Mapping[str, object]) -> Settings:
    """Return validated settings with the given values and defaults for the rest.

    Args:
        cls: a settings dataclass.
        values: value by setting name (``group.name`` in a nested class). Lists become tuples, integers floats.

    Raises:
        SettingsError: a value of a wrong type or out of range, or a name that does not exist.
    """
    descriptions = {description.name: description for description in describe_settings(cls)}
    converted = {}
    for name, value in values.items():
        if name not in descriptions:
            raise SettingsError(_unknown_name_message(name, descriptions.values()))
        converted[name] = _convert(descriptions[name], value)
        check_value(descriptions[name], converted[name])
    return _fill(cls(), converted, '')


def _convert(description: SettingDescription, value: object) -> object:
    if description.is_tuple and isinstance(value, (list, tuple)):
        return tuple(_as_float(element) for element in value)
    return _as_float(value) if description.type is float else value


def _as_float(value: object) -> object:
    return float(value) if isinstance(value, Real) and not isinstance(value, bool) else value


def _fill(defaults: Settings, values: Mapping[str, object], prefix: str) -> Settings:
    hints = get_type_hints(type(defaults))
    group = cast('Any', defaults)  # a dataclass instance; typing has no public name for that
    changes: dict[str, object] = {}
    for field in dataclasses.fields(group):
        name = prefix + field.name
        if dataclasses.is_dataclass(hints[field.name]):
            changes[field.name] = _fill(getattr(group, field.name), values, f'{name}.')
        elif name in values:
            changes[field.name] = values[name]
    return cast('Settings', dataclasses.replace(group, **changes))


def check_settings(settings: object) -> None:
    """Check types, ranges and choices of every value, including nested ones.

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
        raise SettingsError(f'setting {description.name} is {value!r}, it must be {_describe_type(description)}')
    numbers = value if isinstance(value, tuple) else (value,)
    if not all(_is_allowed(description, number) for number in numbers):
        unit = f' {description.unit}' if description.unit else ''
        limits = 'any finite number' if description.limits == 'any' else description.limits
        raise SettingsError(
            f'setting {description.name} is {value!r}{unit}, allowed is {limits} ({description.description})'
        )


def _has_type(description: SettingDescription, value: object) -> bool:
    if description.is_tuple:
        right_length = description.length is None or (isinstance(value, tuple) and len(value) == description.length)
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


def _unknown_name_message(name: str, known: Collection[SettingDescription]) -> str:
    for description in known:
        if description.former_name == name:
            return renamed_message('setting', description)
    names = [description.name for description in known]
    close = get_close_matches(name, names, n=1)
    remedy = f'did you mean {close[0]}?' if close else f'there are {", ".join(names)}'
    return f'setting {name} does not exist, {remedy}'


def renamed_message(what: str, description: SettingDescription) -> str:
    """Return the message for a value that was given under a setting's former name.

    Args:
        what: ``setting`` or ``parameter``.
        description: setting that was renamed.
    """
    old, new = description.former_name, description.name
    return f'{what} {old} is now called {new}; rename it, or run "shirube migrate FILE"'


class _RenamedOption(argparse.Action):
    """Reject an option under its former name with the new one in the message."""

    def __call__(
        self,
        parser: argparse.ArgumentParser,
        namespace: argparse.Namespace,  # noqa: ARG002 argparse wants it
        values: str | Sequence[Any] | None,  # noqa: ARG002
        option_string: str | None = None,
    ) -> None:
        parser.error(f'{option_string} is now called {option_name(self.dest)}')


def reject_former_option(parser: argparse.ArgumentParser, former_name: str, name: str) -> None:
    """Let a parser reject the former name of an option; the help does not show it."""
    parser.add_argument(
        option_name(former_name), dest=name, action=_RenamedOption, default=argparse.SUPPRESS, help=argparse.SUPPRESS
    )


def option_name(setting_name: str) -> str:
    """Return the option of a setting: ``--submap-length`` of ``submap_length``."""
    return f'--{setting_name.replace("_", "-")}'
