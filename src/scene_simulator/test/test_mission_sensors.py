"""Equal seeds give equal pictures, and zones hide what they should."""

import numpy as np
import pytest

from scene_simulator.errors import SceneError
from scene_simulator.imaging.exposure import camera_pose
from scene_simulator.mission.layout import (
    CARPET,
    CEILING_CAMERA,
    CEILING_MOUNT,
    DARK,
    DARK_LAMPS,
    LAMPS,
    NOMINAL,
    lamps_near,
    mission_ceiling,
)
from scene_simulator.mission.sensors import MissionSensors
from shirube_core.geometry import SE2
from shirube_core.waveform import steady_light

STEADY = {name: steady_light() for name in LAMPS}


def pictures(sensors: MissionSensors, place: SE2) -> list[np.ndarray]:
    """Return what all sensors see from a place."""
    others = (sensors.floor_picture, sensors.ceiling_picture, sensors.depth_picture)
    pair = sensors.stereo_pair(3, 1.5, lambda _: place)
    return [*pair, *(picture(3, 1.5, lambda _: place) for picture in others)]


@pytest.mark.newest_set_only
def test_pictures_depend_on_seed_and_number_alone():
    place = SE2(3.0, 2.5, 0.4)
    first, again = (pictures(MissionSensors(2, STEADY), place) for _ in range(2))
    other = pictures(MissionSensors(3, STEADY), place)
    for a, b, c in zip(first, again, other):
        assert a.tobytes() == b.tobytes()
        assert a.tobytes() != c.tobytes()
    one, two = (MissionSensors(2, STEADY).tilt_reading(5, 0.2) for _ in range(2))
    assert one == two


def test_no_dot_is_seen_on_the_carpet():
    sensors, rng = MissionSensors(0, STEADY), np.random.default_rng(1)
    inside = rng.uniform(np.array(CARPET.low) + 0.15, np.array(CARPET.high) - 0.15, (4, 2))
    for x, y in (*inside, (2.0, 3.0)):
        grey = sensors.floor_picture(0, 1.0, lambda _, x=x, y=y: SE2(x, y, 0.3))
        contrast = np.quantile(grey, 0.98) - np.quantile(grey, 0.02)
        assert contrast > 80 if (x, y) == (2.0, 3.0) else contrast < 40


@pytest.mark.parametrize('yaw', [0.0, 0.8, 1.6, 2.4, 3.2, 4.0])
def test_at_the_dark_goal_no_lamp_is_seen(yaw):
    sensors, goal = MissionSensors(0, STEADY), NOMINAL.goals[1]
    assert DARK.contains(goal.x, goal.y)
    dark = sensors.ceiling_picture(0, 1.0, lambda _: SE2(goal.x, goal.y, yaw))
    light = sensors.ceiling_picture(0, 1.0, lambda _: SE2(2.0, 2.0, yaw))
    assert dark.max() < 60
    assert light.max() > 200


@pytest.mark.parametrize('place', [(0.5, 0.5), (3.3, 2.2), (7.0, 1.0)])
def test_lamps_that_are_left_out_would_not_be_seen(place):
    ceiling = mission_ceiling(STEADY, 0)
    near = lamps_near(ceiling, *place)
    assert 0 < len(near.lamps) < len(ceiling.lamps)
    for yaw in (0.0, 0.7, 2.0, 4.0):
        pose = camera_pose(SE2(*place, yaw), CEILING_MOUNT)
        whole, part = (CEILING_CAMERA.photograph(room, lambda _, p=pose: p, 1.0) for room in (ceiling, near))
        assert (whole.image == part.image).all()


def test_the_ceiling_has_all_lamps_but_the_dark_ones():
    ceiling = mission_ceiling(STEADY, 0)
    assert len(ceiling.lamps) == len(LAMPS) - len(DARK_LAMPS)
    with pytest.raises(SceneError, match='lamp 3 has no waveform'):
        mission_ceiling({name: wave for name, wave in STEADY.items() if name != 3}, 0)
