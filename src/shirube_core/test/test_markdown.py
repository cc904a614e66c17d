"""The table of a settings class."""

from __future__ import annotations

import math
from dataclasses import dataclass

from shirube_core.settings import setting, settings_table


@dataclass(frozen=True)
class Camera:
    rpy: tuple[float, float, float] = setting((math.pi, 0.0, -math.pi / 2), 'how it is turned', unit='rad')
    mode: str = setting('a', 'either a|b', choices=('a', 'b'))


def test_the_table_has_a_row_of_equal_cells_for_each_setting() -> None:
    assert settings_table(Camera).splitlines() == [
        '| setting | type | default | unit | allowed | meaning |',
        '| --- | --- | --- | --- | --- | --- |',
        '| `rpy` | tuple[float, float, float] | `(3.14159, 0, -1.5708)` | rad | any | how it is turned |',
        "| `mode` | str | `'a'` |  | 'a' or 'b' | either a\\|b |",
    ]
