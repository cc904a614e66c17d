"""Light that changes evenly in space changes evenly on every plane."""

from __future__ import annotations

import numpy as np
import pytest

from scene_simulator.corridor_light import CorridorLight
from scene_simulator.corridor_shell import CorridorShell


def test_planes_that_meet_have_the_same_light_there() -> None:
    shell, light = CorridorShell(), CorridorLight(0.8, (0.02, 0.1, -0.05))
    edge = np.array([0.0, 0.5 * shell.width, 1.9])
    found = []
    for surface in (shell.surface, shell.left_wall):
        level, right, up = light.on_surface(surface)
        offset = edge - surface.origin
        found.append(level + right * (offset @ surface.right) + up * (offset @ surface.up))
    expected = 0.8 * (1.0 + 0.1 * 0.5 * shell.width - 0.05 * 0.6)
    assert found == pytest.approx([expected, expected])
