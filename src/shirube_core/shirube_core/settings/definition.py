"""Definition of settings, and introspection of a settings class.

A settings class is a frozen dataclass in which every field has a default::

    @dataclass(frozen=True)
    class DotSettings:
        minimum_diameter: float = setting(0.001, 'smallest dot kept', 'm', (0.0, 0.1))


    @dataclass(frozen=True)
    class FloorSettings:
        dots: DotSettings = field(default_factory=DotSettings)  # holds 'dots.minimum_diameter'
"""

import dataclasses
from collections.abc import Callable, Collection, Iterator
from dataclasses import dataclass
from typing import Any, TypeVar, cast, get_args, get_origin, get_type_hints

_METADATA_KEY = 'shirube_setting'
_TUNABLE_FIELDS = '_tunable_fields'
_SCALARS = (float, int, bool, str)

Value = TypeVar('Value')
Settings = TypeVar('Settings')


class SettingsError(ValueError):
    """A setting has a wrong type, is out of range or does not exist; the message is one line."""


@dataclass(frozen=True)
class SettingDescription:
    """Definition of one setting.

    Attributes:
        name: name of the field; ``group.name`` in a nested settings class.
        type: ``float``, ``int``, ``bool``, ``str``, ``tuple[float, ...]`` or ``tuple[float, float, float]``
            (or another fixed number of floats).
        default: default value.
        description: one sentence for the robot's owner.
        unit: unit of the value, ``''`` where it has none.
        minimum: smallest allowed value (of each element of a tuple), None without a limit.
        maximum: largest allowed value (of each element of a tuple), None without a limit.
        choices: allowed values, empty if any value is allowed.
        former_name: name in earlier versions, empty if it was never renamed.
        is_tunable: whether the value may change at run time, see `tunable`.
    """

    name: str
    type: Any
    default: Any
    description: str
    unit: str = ''
    minimum: float | None = None
    maximum: float | None = None
    choices: tuple[Any, ...] = ()
    former_name: str = ''
    is_tunable: bool = False

    @property
    def length(self) -> int | None:
        """Number of elements of a tuple of fixed length, else None."""
        elements = get_args(self.type)
        return len(elements) if elements and Ellipsis not in elements else None

    @property
    def is_tuple(self) -> bool:
        """Whether the value is a tuple of floats."""
        return get_origin(self.type) is tuple

    @property
    def limits(self) -> str:
        """The allowed values as text, such as ``0 to 0.1 m``, ``'a' or 'b'`` or ``any``."""
        unit = f' {self.unit}' if self.unit else ''
        if self.choices:
            return ' or '.join(repr(choice) for choice in self.choices)
        if self.minimum is not None and self.maximum is not None:
            return f'{self.minimum:g} to {self.maximum:g}{unit}'
        if self.minimum is not None:
            return f'{self.minimum:g}{unit} or more'
        if self.maximum is not None:
            return f'{self.maximum:g}{unit} or less'
        return 'any'


def setting(
    default: Value,
    description: str,
    unit: str = '',
    limits: tuple[float | None, float | None] = (None, None),
    *,
    choices: tuple[Value, ...] = (),
    former_name: str = '',
) -> Value:
    """Define a field of a settings dataclass.

    Args:
        default: the default value.
        description: one sentence for the robot's owner.
        unit: unit of the value, ``''`` where it has none.
        limits: smallest and largest allowed value, in ``unit``, of each element of a tuple; None without a limit.
        choices: allowed values, empty if any value is allowed.
        former_name: name in earlier versions, which is now rejected with the new name in the message.

    Returns:
        a dataclass field, typed as its value so that a type checker compares it with the annotation.
    """
    facts = {
        'description': description,
        'unit': unit,
        'minimum': limits[0],
        'maximum': limits[1],
        'choices': choices,
        'former_name': former_name,
    }
    return dataclasses.field(default=default, metadata={_METADATA_KEY: facts})


def tunable(*names: str, fixed: Collection[str] = ()) -> Callable[[type[Settings]], type[Settings]]:
    """Mark settings of a dataclass as tunable: their values may change at run time, the others only at start.

    Args:
        names: names of the fields, empty for all of the class that are no groups.
        fixed: names of fields that are not tunable.
    """

    def mark(cls: type[Settings]) -> type[Settings]:
        fields = names or [field.name for field in dataclasses.fields(cast('Any', cls))]
        setattr(cls, _TUNABLE_FIELDS, frozenset(fields) - set(fixed))
        return cls

    return mark


def describe_settings(cls: type) -> list[SettingDescription]:
    """Return the descriptions of all settings of a class, in the order of its fields.

    Args:
        cls: a settings dataclass; the settings of a nested one are named ``group.name``.

    Raises:
        TypeError: the class is not a dataclass, or a field has no description or an unsupported type.
    """
    return list(_describe(cls(), ''))


def _describe(defaults: object, prefix: str) -> Iterator[SettingDescription]:
    hints = get_type_hints(type(defaults))
    for field in dataclasses.fields(cast('Any', defaults)):
        name, kind, default = prefix + field.name, hints[field.name], getattr(defaults, field.name)
        if dataclasses.is_dataclass(kind):
            yield from _describe(default, f'{name}.')
        elif _METADATA_KEY not in field.metadata:
            raise TypeError(f'{type(defaults).__name__}.{field.name} is not defined by setting()')
        elif not _is_supported(kind):
            raise TypeError(f'{type(defaults).__name__}.{field.name} has the unsupported type {kind}')
        else:
            facts = dict(field.metadata[_METADATA_KEY])
            facts['former_name'] = facts['former_name'] and prefix + facts['former_name']
            is_tunable = field.name in getattr(type(defaults), _TUNABLE_FIELDS, ())
            yield SettingDescription(name, kind, default, **facts, is_tunable=is_tunable)


def _is_supported(kind: object) -> bool:
    if get_origin(kind) is tuple:
        return set(get_args(kind)) - {Ellipsis} == {float}
    return kind in _SCALARS
