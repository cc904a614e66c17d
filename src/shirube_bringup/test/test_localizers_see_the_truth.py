"""The localizers' cores find the true pose in the rendered images."""

import numpy as np
import pytest

from floor_localizer.core.constellation.indexed_map import index_map
from floor_localizer.core.dots import DotMap
from floor_localizer.core.fix import Fix
from floor_localizer.core.localizer import FloorLocalizer
from scene_simulator.mission.floor import BELLY_CAMERA, BELLY_MOUNT, surveyed_floor
from scene_simulator.mission.lamps import LAMPS
from scene_simulator.mission.sensors import MissionSensors
from shirube_bringup.building import PLACES, teach_places
from shirube_core.geometry import SE2
from shirube_core.waveform import steady_light
from stereo_landmark.core.landmark_localizer import LandmarkFix, LandmarkLocalizer
from stereo_landmark.files.place_file import load_place

pytestmark = pytest.mark.newest_set_only
SENSORS = MissionSensors(1, {name: steady_light() for name in LAMPS})


@pytest.mark.timeout(300)  # with nothing compiled yet
def test_dots_give_the_pose_and_the_carpet_none():
    floor = surveyed_floor()
    localizer = FloorLocalizer(index_map(DotMap(floor.points, floor.diameters)), BELLY_MOUNT)
    for index, (x, y, yaw) in enumerate(((1.0, 1.1, 0.1), (6.4, 3.7, 1.5), (2.3, 4.6, -3.0))):
        place = SE2(x, y, yaw)
        picture = SENSORS.floor_picture(index, 1.0 + index, lambda _, place=place: place)
        fix = localizer.locate(picture, BELLY_CAMERA.intrinsics)
        assert isinstance(fix, Fix)
        assert fix.T_map_base.distance_to(place) < 0.002
    hidden = SENSORS.floor_picture(9, 1.0, lambda _: SE2(5.7, 1.2, 0.0))
    assert not isinstance(localizer.locate(hidden, BELLY_CAMERA.intrinsics), Fix)


@pytest.mark.timeout(300)
def test_taught_places_give_the_pose_unless_they_are_covered(tmp_path):
    teach_places(tmp_path)
    localizer = LandmarkLocalizer([load_place(path) for path in sorted(tmp_path.glob('*.yaml'))])
    rng = np.random.default_rng(0)
    for index, (name, (taught, wall)) in enumerate(PLACES.items()):
        place = taught @ SE2(*rng.uniform((-0.2, -0.15, -0.1), (0.2, 0.15, 0.1)).tolist())
        left, right = SENSORS.stereo_pair(index, 1.0, lambda _, place=place: place)
        reading = SENSORS.tilt_reading(index, 1.0)
        fix = localizer.locate(left, right, (reading.roll, reading.pitch))
        if wall == 'west':
            assert not isinstance(fix, LandmarkFix), name
        else:
            assert isinstance(fix, LandmarkFix), name
            assert fix.T_map_base.distance_to(place) < 0.02
