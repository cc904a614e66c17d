"""Bodies of people: their ranges and their clearance agree, and legs rest in turn."""

import math

import numpy as np
import pytest

from scene_simulator.errors import SceneError
from scene_simulator.mission.pedestrians import KINDS, Walker
from scene_simulator.room.box_room import BoxRoom, cast_rays
from shirube_core.geometry import SE2

ROOM = BoxRoom((-5.0, -5.0, 0.0, 5.0, 5.0, 2.5), ((2.0, -1.0, 0.0, 3.0, 1.0, 1.0),))


@pytest.mark.parametrize('kind', KINDS)
def test_the_nearest_range_at_any_height_is_the_clearance(kind: str) -> None:
    solids = Walker(kind, SE2(1.5, 0.3, 0.4), 1.0).solids_at(0.2)
    angles = np.linspace(-math.pi, math.pi, 7200)
    flat = np.column_stack([np.cos(angles), np.sin(angles), 0.0 * angles])
    room = BoxRoom(ROOM.size)
    nearest = min(cast_rays(room, solids, (0.0, 0.0, z), flat).min() for z in np.arange(0.05, 1.8, 0.05))
    assert solids.clearance(0.0, 0.0, 0.0, 2.0) == pytest.approx(nearest, abs=2e-3)


def test_one_leg_rests_while_the_other_swings_and_both_keep_up() -> None:
    walker = Walker('legs', SE2(0.0, 0.0, 0.0), 1.0)
    feet = np.array([[c[0] for c in walker.solids_at(0.01 * k).cylinders[:2]] for k in range(300)])
    speed = np.diff(feet, axis=0) / 0.01
    assert ((np.abs(speed) < 1e-6).any(axis=1)).mean() > 0.95
    np.testing.assert_allclose(feet.mean(axis=1), 0.01 * np.arange(300), atol=0.4)


def test_an_unknown_kind_is_refused() -> None:
    with pytest.raises(SceneError, match='give one of person'):
        Walker('ghost', SE2(0.0, 0.0, 0.0), 1.0)
