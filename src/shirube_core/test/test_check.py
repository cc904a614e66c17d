"""Which values the check accepts and rejects, and its messages."""

import math
from dataclasses import dataclass, field
from typing import Any

import pytest

from shirube_core.settings import SettingsError, check_settings, setting


@dataclass(frozen=True)
class Dots:
    diameter: float = setting(0.002, 'smallest dot kept', 'm', (0.0005, 0.1))


@dataclass(frozen=True)
class Floor:
    dots: Dots = field(default_factory=Dots)
    count: int = setting(5, 'fewest dots', limits=(3, None))
    enabled: bool = setting(True, 'whether it works')
    method: str = setting('pole', 'which way', choices=('pole', 'pair'))
    xyz: tuple[float, float, float] = setting((0.0, 0.0, 0.1), 'where it sits', 'm', (-1.0, None))
    weights: tuple[float, ...] = setting((), 'weights', limits=(0.0, None))


@pytest.mark.parametrize(
    'settings',
    [
        Floor(),
        Floor(dots=Dots(0.0005)),
        Floor(dots=Dots(0.1)),
        Floor(dots=Dots(1e-2), count=3, enabled=False, method='pair', xyz=(-1, 2, 3), weights=(0.0, 1.0)),
    ],
)
def test_values_inside_and_on_the_limits_pass(settings: Floor) -> None:
    check_settings(settings)


@pytest.mark.parametrize(
    ('bad', 'words'),
    [
        ({'dots': Dots(0.00049)}, r'dots\.diameter is 0.00049 m, allowed is 0.0005 to 0.1 m \(smallest dot'),
        ({'dots': Dots(0.2)}, r'dots\.diameter is 0.2 m'),
        ({'dots': Dots(math.nan)}, r'dots\.diameter is nan m'),
        ({'dots': Dots('2')}, r"dots\.diameter is '2', it must be a number"),
        ({'count': 2}, r'count is 2, allowed is 3 or more'),
        ({'count': 4.0}, r'count is 4.0, it must be a whole number'),
        ({'count': True}, r'count is True, it must be a whole number'),
        ({'enabled': 1}, r'enabled is 1, it must be true or false'),
        ({'method': 'star'}, r"method is 'star', allowed is 'pole' or 'pair'"),
        ({'xyz': (0.0, 0.0)}, r'xyz is \(0.0, 0.0\), it must be 3 numbers'),
        ({'xyz': (0.0, -2.0, 0.0)}, r'allowed is -1 m or more'),
        ({'xyz': (0.0, math.inf, 0.0)}, r'xyz is \(0.0, inf, 0.0\) m'),
        ({'weights': (1.0, -1.0)}, r'weights is .* allowed is 0 or more'),
        ({'weights': 1.0}, r'weights is 1.0, it must be numbers'),
    ],
)
def test_a_bad_value_is_refused_in_one_line_with_the_remedy(bad: dict[str, Any], words: str) -> None:
    with pytest.raises(SettingsError, match=words) as refusal:
        check_settings(Floor(**bad))
    assert '\n' not in str(refusal.value)


def test_infinity_is_refused_where_there_is_no_limit() -> None:
    @dataclass(frozen=True)
    class Free:
        x: float = setting(0.0, 'anything')

    with pytest.raises(SettingsError, match='x is inf, allowed is any finite number'):
        check_settings(Free(math.inf))
