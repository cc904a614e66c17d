"""The clearance of a cylinder equals a brute-force search over points of its rim."""

from __future__ import annotations

import numpy as np
import pytest

from scene_simulator.box_room import BoxRoom
from scene_simulator.disc_clearance import disc_clearance

ROOM = BoxRoom(
    (0.0, 0.0, 0.0, 4.0, 3.0, 2.5),
    ((1.0, 1.0, 0.0, 1.6, 1.4, 0.8), (2.5, 2.0, 0.7, 3.2, 2.6, 0.75), (2.0, 0.2, 1.5, 3.0, 1.0, 2.0)),
)
RADIUS, HEIGHT = 0.2, 1.3


def touches(x: float, y: float, radius: float) -> bool:
    """Look at many points of a disc."""
    angles = np.linspace(0.0, 2.0 * np.pi, 720)
    rim = radius * np.linspace(0.0, 1.0, 40)[:, None]
    px, py = x + rim * np.cos(angles), y + rim * np.sin(angles)
    solid = (px <= 0.0) | (px >= 4.0) | (py <= 0.0) | (py >= 3.0)
    for x0, y0, z0, x1, y1, _ in ROOM.boxes:
        if z0 < HEIGHT:
            solid |= (px > x0) & (px < x1) & (py > y0) & (py < y1)
    return bool(solid.any())


@pytest.mark.parametrize('seed', range(60))
def test_a_disc_just_smaller_than_the_clearance_fits_and_one_just_larger_does_not(seed):
    x, y = np.random.default_rng(seed).uniform((0.05, 0.05), (3.95, 2.95)).tolist()
    free = disc_clearance(ROOM, x, y, RADIUS, HEIGHT) + RADIUS
    if free > 0.02:
        assert not touches(x, y, free - 0.01)
    assert touches(x, y, free + 0.02)


def test_what_hangs_higher_does_not_count_for_a_low_robot():
    under = 2.5, 0.6
    assert disc_clearance(ROOM, *under, RADIUS, 1.4) > 0.0
    assert disc_clearance(ROOM, *under, RADIUS, 1.6) < 0.0
