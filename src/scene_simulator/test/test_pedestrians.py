"""People of the mission walk to and fro on free ways and never into the robot."""

import math

import numpy as np
import pytest

from scene_simulator.mission.layout import ROBOT_HEIGHT, ROBOT_RADIUS, mission_layout, mission_obstacles
from scene_simulator.mission.pedestrians import HEIGHT, RADIUS, Pedestrian, mission_pedestrians, solids_at
from scene_simulator.mission.sensors import DEPTH_CAMERA, DEPTH_MOUNT, MissionSensors
from scene_simulator.room.box_room import disc_clearance
from shirube_core.geometry import SE2

FAR = SE2(100.0, 100.0, 0.0)


@pytest.mark.parametrize('seed', range(3))
def test_ways_are_free_of_furniture(seed):
    layout = mission_layout(seed)
    room = mission_obstacles(seed, layout)
    people = mission_pedestrians(seed, 3, room, layout)
    assert people == mission_pedestrians(seed, 3, room, layout)
    for person in people:
        for _ in range(300):
            person.advance(0.1, FAR)
            assert disc_clearance(room.boxes, *person.place, RADIUS, HEIGHT) > 0.0


def test_a_person_walks_to_the_end_and_back_at_the_speed():
    person = Pedestrian((0.0, 0.0), (3.0, 4.0), 1.0)
    places = []
    for _ in range(1000):
        places.append(person.place)
        person.advance(0.01, FAR)
    steps = np.hypot(*np.diff(places, axis=0).T)
    assert np.median(steps) == pytest.approx(0.01, abs=1e-9)
    assert steps.max() < 0.01 + 1e-9
    assert math.dist(places[500], person.end) < 0.02
    assert math.dist(person.place, person.start) < 0.02


@pytest.mark.parametrize('aside', [0.0, 0.2, 0.4])
def test_a_person_never_walks_into_a_robot_that_stands(aside):
    robot, person = SE2(2.0, aside, 0.0), Pedestrian((0.0, 0.0), (4.0, 0.0), 1.3)
    gaps = []
    for _ in range(2000):
        person.advance(0.02, robot)
        gaps.append(solids_at([person.place]).clearance(robot.x, robot.y, ROBOT_RADIUS, ROBOT_HEIGHT))
    assert 0.3 < min(gaps) < 0.5


def test_the_depth_camera_sees_a_person_where_it_is():
    sensors = MissionSensors(0, {})
    start = sensors.layout.start
    ahead = (start @ SE2(DEPTH_MOUNT.xyz[0] + 1.5, 0.0, 0.0)).transform([(0.0, 0.0)])[0]
    depth = sensors.depth_picture(0, 0.0, lambda _: start, [(ahead[0], ahead[1])])
    middle = depth[DEPTH_CAMERA.height // 2, DEPTH_CAMERA.width // 2]
    assert middle == pytest.approx(1.5 - RADIUS, abs=0.05)
