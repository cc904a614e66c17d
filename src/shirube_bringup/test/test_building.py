"""Places that are taught on rendered images give the true pose."""

import numpy as np
import pytest

from scene_simulator.mission.layout import LAMPS
from scene_simulator.mission.sensors import MissionSensors
from shirube_bringup.building import PLACES, teach_places
from shirube_core.geometry import SE2
from shirube_core.waveform import steady_light
from stereo_landmark.core.landmark_localizer import LandmarkFix, LandmarkLocalizer
from stereo_landmark.files.place_file import load_place


@pytest.mark.newest_set_only
@pytest.mark.timeout(300)  # with nothing compiled yet
def test_taught_places_give_the_pose_unless_they_are_covered(tmp_path):
    teach_places(tmp_path)
    sensors = MissionSensors(1, {name: steady_light() for name in LAMPS})
    localizer = LandmarkLocalizer([load_place(path) for path in sorted(tmp_path.glob('*.yaml'))])
    rng = np.random.default_rng(0)
    for index, (name, (taught, wall)) in enumerate(PLACES.items()):
        place = taught @ SE2(*rng.uniform((-0.2, -0.15, -0.1), (0.2, 0.15, 0.1)).tolist())
        left, right = sensors.stereo_pair(index, 1.0, lambda _, place=place: place)
        reading = sensors.tilt_reading(index, 1.0)
        fix = localizer.locate(left, right, (reading.roll, reading.pitch))
        if wall == 'west':
            assert not isinstance(fix, LandmarkFix), name
        else:
            assert isinstance(fix, LandmarkFix), name
            assert fix.T_map_base.distance_to(place) < 0.02
