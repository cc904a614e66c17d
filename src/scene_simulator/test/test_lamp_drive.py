"""What a drive records, against its truth."""

import math
from itertools import islice

import numpy as np
import pytest
from simulated_robot import SimulatedRobot

from scene_simulator.ceiling.camera import CeilingCamera
from scene_simulator.ceiling.lamp_drive import LampDrive, paper_room
from scene_simulator.errors import SceneError
from scene_simulator.imaging.exposure import CameraClock, Shutter
from scene_simulator.robot.leg_drive import LegDrive
from scene_simulator.robot.robot_drive import WheelErrors
from shirube_core.geometry import SE2, CameraMount, PinholeCamera
from shirube_core.waveform import steady_light

EYE = CeilingCamera(PinholeCamera(320, 256, 159.0, 159.0, 159.5, 127.5), Shutter(0.5e-3, 30e-6))
ROUTE = LegDrive([(0.0, 0.5), (1.5, 0.5), (1.5, -0.5)], [0.5, 0.3], 0.3)
ROOM = paper_room([steady_light() for _ in range(4)])
DRIVE = LampDrive(
    ROOM, ROUTE, EYE, CameraMount((0.1, 0.02, 0.4), (0.01, 0.0, 1.6)), clock=CameraClock(20.0, 1e-4), seed=3
)


def test_frames_know_where_they_were_taken() -> None:
    frames = list(islice(DRIVE.frames(3.0), 30, None))
    assert len(frames) == DRIVE.frame_count(3.0) - 30 > 5
    for frame in frames:
        photo = frame.photo
        assert frame.pose == DRIVE.pose_at(photo.stamp)
        assert abs(frame.stamp - photo.stamp) < 6e-4
        for seen in photo.lamp_projections:
            camera = DRIVE.camera_pose_at(seen.time)
            (pixel,) = EYE.intrinsics.pixels_from_points(camera.camera_points([ROOM.lamps[seen.lamp].xyz]))
            np.testing.assert_allclose(seen.centre, pixel, atol=1e-3)
            u, v = np.rint(pixel).astype(int)
            assert photo.image[v, u] > 100


def test_the_camera_tilts_with_the_body() -> None:
    for time in (0.0, 1.7):
        roll, pitch = DRIVE.tilt_at(time)
        up = DRIVE.camera_pose_at(time).rotation @ DRIVE.mount.rotation.T[:, 2]
        yaw = DRIVE.pose_at(time).yaw
        # To first order a pitch leans the body's up ahead, and a roll to its right.
        (x, y), *_ = SE2(0.0, 0.0, yaw).transform([(pitch, -roll)])
        np.testing.assert_allclose(up, [x, y, 1.0], atol=5e-4)
        assert 0.0 < math.hypot(roll, pitch) < math.radians(1.0)


def test_wheels_without_errors_measure_the_drive() -> None:
    perfect = LampDrive(ROOM, ROUTE, wheels=WheelErrors(0.3, 1e-9, 1.0, 1.0, 0.0))
    readings = perfect.odometry(ROUTE.duration)
    for reading in readings[::40]:
        true = ROUTE.pose_at(0.0).inverse() @ ROUTE.pose_at(reading.time)
        assert reading.pose.distance_to(true) < 1e-3
        assert abs(reading.pose.yaw_to(true)) < 1e-6
    assert max(reading.forward for reading in readings) == pytest.approx(0.5, rel=1e-3)
    assert min(reading.yaw_rate for reading in readings) == pytest.approx(-1.0, rel=1e-2)


def test_good_wheels_err_by_two_percent_and_a_fifth_of_a_degree_a_metre() -> None:
    straight = LegDrive([(0.0, 0.0), (10.0, 0.0)], [1.0], 1.0)
    ends = [LampDrive(ROOM, straight, seed=seed).odometry(straight.duration)[-1].pose for seed in range(12)]
    assert np.mean([end.x for end in ends]) == pytest.approx(10.2, abs=0.03)
    assert math.degrees(np.mean([end.yaw for end in ends])) / 10.0 == pytest.approx(0.2, abs=0.05)


def test_a_robot_may_be_driven_by_what_its_camera_sees() -> None:
    robot = SimulatedRobot(SE2(0.3, 0.4, 0.0))
    recorded = LampDrive(ROOM, robot, EYE, clock=CameraClock(20.0))
    frames = recorded.frames(2.0)
    for index in range(recorded.frame_count(2.0)):
        robot.drive(0.3, 0.5 if index > 20 else 0.0, EYE.shutter.frame_end(index / 20.0, 256))
        frame = next(frames)
        assert frame.pose == robot.pose_at(index / 20.0)
    assert recorded.pose_at(1.0).x > 0.5
    with pytest.raises(SceneError, match='driven until'):
        recorded.odometry(3.0)
