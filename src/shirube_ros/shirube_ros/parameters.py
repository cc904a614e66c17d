"""Declares a node's parameters from a settings class, with descriptions and ranges, and checks changes of them."""

import math
from collections.abc import Iterable, Mapping, Sequence
from difflib import get_close_matches
from functools import reduce
from typing import TypeVar, cast

from rcl_interfaces.msg import FloatingPointRange, IntegerRange, ParameterDescriptor
from rclpy.node import Node
from rclpy.parameter import Parameter

from shirube_core.settings import (
    SettingDescription,
    SettingsError,
    describe_settings,
    renamed_message,
    settings_from_values,
)

Settings = TypeVar('Settings')

_INT64_MAX = 2**63 - 1
_CLOSE = 0.8  # similarity of a misspelled name to the name that is meant


def declare_parameters(node: Node, cls: type[Settings], *, allow_tuning: bool = False) -> Settings:
    """Declare all settings of a settings class as parameters of a node; return them with the user's values.

    A setting of a nested class is the parameter ``group.name``. Integers are converted to floats, so that
    ``height:=1`` works as well as ``height:=1.0``. Parameters are read-only, but for tunable ones with
    ``allow_tuning``.

    Raises:
        SettingsError: a value of a wrong type or out of range, or a former name; names parameter and remedy.
    """
    descriptions = describe_settings(cls)
    for description in descriptions:
        if description.former_name in node._parameter_overrides:  # noqa: SLF001 rclpy has no public API for them
            raise SettingsError(renamed_message('parameter', description))
    values = {description.name: _given_value(node, description) for description in descriptions}
    settings = settings_from_values(cls, values)
    for description in descriptions:
        value = _value_of(settings, description.name)
        descriptor = _descriptor(description)
        descriptor.read_only = not (allow_tuning and description.is_tunable)
        node.declare_parameter(description.name, value, descriptor, ignore_override=True)
    return settings


def change_settings(node: Node, settings: Mapping[type, object], parameters: Sequence[Parameter]) -> dict[type, object]:
    """Return the settings, by class, that changed parameters of a node belong to, with the new values.

    Raises:
        SettingsError: an unknown parameter, one that can only be set at start, or a value of a wrong type or out of
            range.
    """
    for parameter in parameters:
        name, value = parameter.name, parameter.value
        if not node.has_parameter(name):
            raise SettingsError(_unknown_message(name, list(node._parameters)))  # noqa: SLF001 as below
        if node.describe_parameter(name).read_only:
            remedy = '' if value is None else f': restart the node with {name}:={value}'
            raise SettingsError(f'{name} can only be set at start{remedy}')
    changes: dict[type, object] = {}
    for cls, current in settings.items():
        descriptions = {description.name: description for description in describe_settings(cls)}
        given = {
            parameter.name: _as_setting(descriptions[parameter.name], parameter.value)
            for parameter in parameters
            if parameter.name in descriptions
        }
        if given:
            values = {name: _value_of(current, name) for name in descriptions}
            changes[cls] = settings_from_values(cls, values | given)
    return changes


def changed_parameters(node: Node, parameters: Sequence[Parameter]) -> list[Parameter]:
    """Leave out what can only be set at start and has its value already: a ``ros2 param dump`` can be loaded."""
    fixed = {name for name in node._parameters if node.describe_parameter(name).read_only}  # noqa: SLF001 as below
    return [p for p in parameters if p.name not in fixed or _plain(p) != _plain(node.get_parameter(p.name))]


def _plain(parameter: Parameter) -> tuple[bool, object]:
    """Return a value that can be compared: ROS has lists and arrays, and reads an empty one as None."""
    value = parameter.value
    is_list = not isinstance(value, (str, bool, int, float))
    return isinstance(value, bool), list(value or ()) if is_list else value


def parameters_of(settings: Mapping[type, object], parameters: Sequence[Parameter]) -> list[Parameter]:
    """Return parameters with the values of the settings, whose types are those that were declared."""
    names = {description.name: cls for cls in settings for description in describe_settings(cls)}
    return [
        Parameter(each.name, value=_value_of(settings[names[each.name]], each.name)) if each.name in names else each
        for each in parameters
    ]


def reject_misspelled_parameters(node: Node) -> None:
    """Reject a given parameter whose name is close to a declared one; warn of other unknown names.

    A file for many nodes (``/**``) may contain parameters of other nodes, so an unknown name alone is no error.

    Raises:
        SettingsError: a name that is close to one that is declared; the message names both.
    """
    declared = list(node._parameters)  # noqa: SLF001 rclpy has no public API for the given parameters
    for name in sorted(node._parameter_overrides.keys() - set(declared)):  # noqa: SLF001
        if name.startswith('qos_overrides.'):
            continue
        if get_close_matches(name, declared, n=1, cutoff=_CLOSE):
            raise SettingsError(_unknown_message(name, declared))
        node.get_logger().warning(f'parameter {name} does not exist in this node and is ignored')


def _unknown_message(name: str, declared: list[str]) -> str:
    close = get_close_matches(name, declared, n=1, cutoff=_CLOSE)
    return f'parameter {name} does not exist' + (f', did you mean {close[0]}?' if close else ' in this node')


def _given_value(node: Node, description: SettingDescription) -> object:
    """Read an override of any type: rclpy's own type error names neither range nor remedy."""
    untyped = ParameterDescriptor(dynamic_typing=True)
    value = node.declare_parameter(description.name, _as_parameter(description.default), untyped).value
    node.undeclare_parameter(description.name)
    return _as_setting(description, value)


def _as_setting(description: SettingDescription, value: object) -> object:
    if description.is_tuple and value is not None and not isinstance(value, (str, bytes, bool, int, float)):
        return list(cast('Iterable[object]', value))
    if description.is_tuple and value is None:
        return []  # ROS reads an empty list as a parameter without a value
    return value


def _value_of(settings: object, name: str) -> object:
    return _as_parameter(reduce(getattr, name.split('.'), settings))


def _as_parameter(value: object) -> object:
    return list(value) if isinstance(value, tuple) else value


def _descriptor(description: SettingDescription) -> ParameterDescriptor:
    unit = f' [{description.unit}]' if description.unit else ''
    descriptor = ParameterDescriptor(description=f'{description.description}{unit}')
    if description.limits != 'any':
        descriptor.additional_constraints = description.limits
    low, high = description.minimum, description.maximum
    if low is None and high is None:
        return descriptor
    if description.type is float:
        least, most = -math.inf if low is None else float(low), math.inf if high is None else float(high)
        descriptor.floating_point_range = [FloatingPointRange(from_value=least, to_value=most)]
    elif description.type is int:
        first, last = (-_INT64_MAX if low is None else math.ceil(low), _INT64_MAX if high is None else math.floor(high))
        descriptor.integer_range = [IntegerRange(from_value=first, to_value=last)]
    return descriptor
