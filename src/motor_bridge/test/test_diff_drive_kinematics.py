import math

import pytest

from motor_bridge.core.diff_drive_kinematics import DiffDriveKinematics, DriveSettings, Velocity, check_velocity
from motor_bridge.core.encoder_odometry import velocity_from_distances
from motor_bridge.core.motor_bridge_error import MotorBridgeError

SETTINGS = DriveSettings()
BASE = DiffDriveKinematics(SETTINGS)


@pytest.mark.parametrize('pair', [(0.3, 0.0), (0.0, 1.2), (-0.2, -0.7)])
def test_wheels_and_velocities_are_inverse(pair):
    distances = [ticks * BASE.metres_per_tick for ticks in BASE.to_wheel_ticks(Velocity(*pair))]
    back = velocity_from_distances(*distances, BASE.frame, BASE.separation)
    assert (back.forward, back.turn_rate) == pytest.approx(pair)


def test_counterclockwise_turns_are_driven_by_the_right_wheel():
    left, right = BASE.to_wheel_ticks(Velocity(0.0, 1.0))
    assert left == -right
    assert right > 0.0


def test_a_revolution_a_second_is_as_many_ticks_as_the_encoder_has():
    left, _ = BASE.to_wheel_ticks(Velocity(math.tau * SETTINGS.wheel_radius, 0.0))
    assert left / SETTINGS.pid_frame == pytest.approx(1440.0)


def test_impossible_wheels_are_refused_in_one_line():
    for settings, words in (
        (DriveSettings(ticks_per_revolution=1_000_000), 'the controller accepts 32767; check them'),
        (DriveSettings(ticks_per_revolution=4, max_linear_velocity=0.05), 'below the resolution of 1'),
    ):
        with pytest.raises(MotorBridgeError, match=words) as refusal:
            DiffDriveKinematics(settings)
        assert '\n' not in str(refusal.value)


@pytest.mark.parametrize('pair', [(float('nan'), 0.0), (0.0, float('inf')), (-float('inf'), 1.0)])
def test_velocities_that_are_not_finite_are_refused(pair):
    with pytest.raises(MotorBridgeError, match='cmd_vel has a velocity that is not finite'):
        check_velocity(*pair)
