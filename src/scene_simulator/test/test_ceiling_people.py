"""People occlude what is behind them, no more and no less, and walk to and fro."""

import math

import numpy as np
import pytest

from scene_simulator.ceiling.camera import UPWARD_MOUNT, CeilingCamera, CeilingPhoto
from scene_simulator.ceiling.lamp import CeilingLamp, Disc
from scene_simulator.ceiling.room import CeilingRoom, Person
from scene_simulator.errors import SceneError
from scene_simulator.imaging.exposure import camera_pose
from shirube_core.geometry import SE2, PinholeCamera

EYE = CeilingCamera(PinholeCamera(320, 320, 160.0, 160.0, 159.5, 159.5))


def photograph(people: tuple[Person, ...]) -> CeilingPhoto:
    """Return the photograph of a lamp at each place of a grid, by a turned camera that is not at the origin."""
    places = [(x, y, 2.5) for x in np.arange(-1.0, 3.1, 0.25) for y in np.arange(-2.0, 2.1, 0.25)]
    room = CeilingRoom(tuple(CeilingLamp(place, Disc(0.05)) for place in places), people=people)
    return EYE.photograph(room, lambda _: camera_pose(SE2(1.0, 0.0, 0.7), UPWARD_MOUNT), 0.0)


def test_a_lamp_is_dark_if_and_only_if_its_ray_meets_the_person() -> None:
    person = Person((1.5, 0.4), (1.5, 0.4), 1.5, radius=0.25)
    free, hidden = photograph(()), photograph((person,))
    inside = 0
    for before in free.lamp_projections:
        u, v = (round(x) for x in before.centre)
        x, y, z = -1.0 + 0.25 * (before.lamp // 17), -2.0 + 0.25 * (before.lamp % 17), 2.5
        # Points of the segment from the camera to the lamp that are not above the head.
        share = np.linspace(0.0, person.height / z, 2000)
        distance = np.hypot(1.0 + share * (x - 1.0) - 1.5, share * y - 0.4).min()
        if abs(distance - person.radius) > 0.04 and free.image[v, u] > 100:
            assert (hidden.image[v, u] < 10) == (distance < person.radius)
            inside += distance < person.radius
    assert inside > 5


def test_people_walk_at_their_speed_and_turn_round() -> None:
    person = Person((0.0, 0.0), (3.0, 4.0), 1.5, speed=2.0)
    assert [person.position_at(t) for t in (0.0, 1.25, 2.5, 3.75, 5.0)] == pytest.approx(
        [(0.0, 0.0), (1.5, 2.0), (3.0, 4.0), (1.5, 2.0), (0.0, 0.0)]
    )
    assert Person((1.0, 2.0), (3.0, 4.0), 1.5, speed=0.0).position_at(9.0) == (1.0, 2.0)


@pytest.mark.parametrize('given', [{'radius': 0.0}, {'speed': -1.0}, {'speed': math.nan}])
def test_a_person_that_cannot_be_is_refused(given: dict[str, float]) -> None:
    with pytest.raises(SceneError, match='a person has'):
        Person((0.0, 0.0), (1.0, 0.0), 1.5, **given)
