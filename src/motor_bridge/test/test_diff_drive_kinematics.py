import pytest

from motor_bridge.core.diff_drive_kinematics import DiffDriveKinematics, Velocity, check_velocity
from motor_bridge.core.drive_settings import DriveSettings
from motor_bridge.core.motor_bridge_error import MotorBridgeError

BASE = DiffDriveKinematics(DriveSettings())


@pytest.mark.parametrize('velocity', [Velocity(0.3, 0.0), Velocity(0.0, 1.2), Velocity(-0.2, -0.7)])
def test_the_mean_of_the_wheels_drives_and_their_difference_turns(velocity):
    left, right = (BASE.metres_per_tick / BASE.frame * ticks for ticks in BASE.to_wheel_ticks(velocity))
    assert 0.5 * (left + right) == pytest.approx(velocity.forward)
    assert right - left == pytest.approx(BASE.separation * velocity.turn_rate)


def test_counterclockwise_turns_are_driven_by_the_right_wheel():
    left, right = BASE.to_wheel_ticks(Velocity(0.0, 1.0))
    assert left == -right
    assert right > 0.0


def test_a_revolution_a_second_is_as_many_ticks_as_the_encoder_has():
    settings = DriveSettings()
    way = 2.0 * 3.141592653589793 * settings.wheel_radius
    assert BASE.to_wheel_ticks(Velocity(way, 0.0))[0] * 1.0 / settings.pid_frame == pytest.approx(1440.0)


@pytest.mark.parametrize(
    ('settings', 'words'),
    [
        (
            DriveSettings(ticks_per_revolution=1_000_000),
            'ticks per frame, the controller accepts 32767; check them',
        ),
        (DriveSettings(ticks_per_revolution=4, max_linear_velocity=0.05), 'below the resolution of 1'),
    ],
)
def test_impossible_wheels_are_refused_in_one_line(settings, words):
    with pytest.raises(MotorBridgeError, match=words) as refusal:
        DiffDriveKinematics(settings)
    assert '\n' not in str(refusal.value)


@pytest.mark.parametrize('pair', [(float('nan'), 0.0), (0.0, float('inf')), (-float('inf'), 1.0)])
def test_velocities_that_are_not_finite_are_refused(pair):
    with pytest.raises(MotorBridgeError, match='cmd_vel has a velocity that is not finite'):
        check_velocity(*pair)
