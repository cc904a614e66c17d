"""Arcs against many small straight steps."""

from __future__ import annotations

import math

import pytest

from scene_simulator.arc_motion import arc_motion
from shirube_core.geometry import SE2


@pytest.mark.parametrize('turn', [0.0, 1e-9, 0.7, -2.5])
@pytest.mark.parametrize('way', [1.3, -0.4, 0.0])
def test_an_arc_is_many_small_steps(way: float, turn: float) -> None:
    steps = 2000
    pose = SE2(0.0, 0.0, 0.0)
    for _ in range(steps):
        half = SE2(0.0, 0.0, 0.5 * turn / steps)
        pose = pose @ half @ SE2(way / steps, 0.0, 0.0) @ half
    found = arc_motion(way, turn)
    assert found.distance_to(pose) < 1e-6
    assert found.yaw_to(pose) == pytest.approx(0.0, abs=1e-9)


def test_a_quarter_circle_ends_a_radius_ahead_and_aside() -> None:
    end = arc_motion(0.5 * math.pi * 2.0, 0.5 * math.pi)
    assert (end.x, end.y, end.yaw) == pytest.approx((2.0, 2.0, 0.5 * math.pi))
