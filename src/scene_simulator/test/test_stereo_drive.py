"""A drive gives its pictures at its rate, from where the robot is, in corridors that differ as they should."""

import math
from dataclasses import replace

import numpy as np
import pytest

from scene_simulator.corridor.stereo_drive import RUNS, SECONDS, TAUGHT_POSE, StereoDrive, make_corridor_drive
from scene_simulator.corridor.stereo_rig import render_pair
from scene_simulator.errors import SceneError
from scene_simulator.robot.leg_drive import Suspension


@pytest.mark.parametrize('name', RUNS)
def test_the_robot_is_stationary_at_its_goal_for_the_last_second(name: str) -> None:
    drive, goal = make_corridor_drive(name), RUNS[name].goal
    assert drive.route.duration < SECONDS - 0.9
    for time in (drive.route.duration, SECONDS):
        pose = drive.pose_at(time)
        assert pose.distance_to(goal) < 1e-9
        assert pose.yaw_to(goal) == pytest.approx(0.0, abs=1e-9)


def test_offsets_reach_half_a_metre_and_fifteen_degrees_to_both_sides() -> None:
    offsets = [TAUGHT_POSE.inverse() @ run.goal for run in RUNS.values()]
    assert (min(o.y for o in offsets), max(o.y for o in offsets)) == pytest.approx((-0.5, 0.5))
    turns = [math.degrees(o.yaw) for o in offsets]
    assert (min(turns), max(turns)) == pytest.approx((-15.0, 15.0))


def test_only_the_moved_sign_is_elsewhere() -> None:
    taught, moved = (make_corridor_drive(name).scene.points_map() for name in ('teach', 'moved'))
    elsewhere = [name for name, point in taught.items() if not np.allclose(point, moved[name])]
    assert elsewhere == ['round_sign']


@pytest.fixture(scope='module')
def drive() -> StereoDrive:
    return make_corridor_drive('left')


def test_pictures_come_at_the_rate_from_the_true_pose(drive: StereoDrive) -> None:
    still = replace(drive, suspension=Suspension(0.0, 0.0))
    frames = list(still.frames(0.9))
    assert [frame.stamp for frame in frames] == pytest.approx([0.0, 1.0 / 3.0, 2.0 / 3.0])
    assert still.frame_count(0.9) == 3
    assert frames[2].pose == drive.pose_at(2.0 / 3.0)
    clean = render_pair(drive.scene, drive.rig, frames[2].pose)
    for seen, expected in zip((frames[2].left, frames[2].right), clean, strict=True):
        difference = seen.astype(float) - expected
        assert abs(difference.mean()) < 0.2
        assert 0.5 < difference.std() < 3.0


def test_a_body_that_sways_changes_the_picture_and_the_tilt_readings(drive: StereoDrive) -> None:
    swaying, still = (replace(drive, suspension=Suspension(0.0, tilt)) for tilt in (0.02, 0.0))
    first, second = (next(iter(x.frames(0.1))).left.astype(float) for x in (swaying, still))
    assert np.abs(first - second).mean() > 3.0
    readings = swaying.tilt_readings(2.0)
    truth = np.array([swaying.tilt_at(reading.time) for reading in readings])
    read = np.array([(reading.roll, reading.pitch) for reading in readings])
    assert np.abs(read - truth).max() < 0.005
    assert np.abs(truth).max() > 0.005


def test_the_odometry_drifts_by_a_few_percent(drive: StereoDrive) -> None:
    last = drive.odometry(5.0)[-1]
    assert last.pose.x == pytest.approx(1.02, abs=0.005)
    assert abs(last.pose.y) < 0.02


def test_impossible_drives_are_refused(drive: StereoDrive) -> None:
    with pytest.raises(SceneError, match='choose one of teach, left'):
        make_corridor_drive('sideways')
    for change, complaint in (({'rate': 0.0}, 'pictures a second'), ({'seed': -1}, 'seed')):
        with pytest.raises(SceneError, match=complaint):
            replace(drive, **change)
    for seconds in (0.0, -1.0, float('nan')):
        with pytest.raises(SceneError, match='seconds'):
            drive.frame_count(seconds)
