"""Introspection of definitions, their supported types, and their table."""

from dataclasses import dataclass, field

import pytest

from shirube_core.settings import describe_settings, setting, tunable


@dataclass(frozen=True)
class Lens:
    focal: float = setting(8.0, 'focal length', 'mm', (1.0, None))


@dataclass(frozen=True)
class Camera:
    name: str = setting('belly', 'name of the camera')
    size: tuple[float, float, float] = setting((1.0, 2.0, 3.0), 'size of its body', 'm', (None, 9.0))
    lens: Lens = field(default_factory=lambda: Lens(focal=4.0))
    gains: tuple[float, ...] = setting((), 'gains')
    mode: str = setting('fast', 'mode of work', choices=('fast', 'good'))


def test_every_fact_of_a_definition_is_read_back_in_order() -> None:
    by_name = {description.name: description for description in describe_settings(Camera)}
    assert list(by_name) == ['name', 'size', 'lens.focal', 'gains', 'mode']
    size = by_name['size']
    assert (size.default, size.description, size.unit) == ((1.0, 2.0, 3.0), 'size of its body', 'm')
    assert (size.minimum, size.maximum, size.length, size.is_tuple) == (None, 9.0, 3, True)
    assert by_name['gains'].length is None
    assert by_name['lens.focal'].default == 4.0  # as the outer class says
    assert by_name['mode'].choices == ('fast', 'good')
    types = [by_name[name].type for name in ('name', 'size', 'gains')]
    assert types == [str, tuple[float, float, float], tuple[float, ...]]


def test_tunable_settings_are_those_that_are_named_or_all_but_the_fixed_ones() -> None:
    marked = tunable(fixed=('mode',))(Camera)
    assert [each.name for each in describe_settings(marked) if each.is_tunable] == ['name', 'size', 'gains']


def test_an_undescribed_field_and_an_unknown_type_are_refused() -> None:
    @dataclass(frozen=True)
    class Undescribed:
        x: float = 1.0

    @dataclass(frozen=True)
    class Unsupported:
        x: complex = setting(1j, 'a complex number')

    with pytest.raises(TypeError, match=r'Undescribed\.x'):
        describe_settings(Undescribed)
    with pytest.raises(TypeError, match=r'Unsupported\.x .*complex'):
        describe_settings(Unsupported)
