"""Velocity of a differential drive base, and its kinematics in the units of the motor controller."""

import math
from dataclasses import dataclass

from motor_bridge.core.motor_bridge_error import MotorBridgeError
from shirube_core.settings import setting, tunable


@tunable(
    'cmd_vel_timeout',
    'max_linear_velocity',
    'max_angular_velocity',
    'max_linear_acceleration',
    'max_angular_acceleration',
    'max_linear_jerk',
)
@dataclass(frozen=True)
class DriveSettings:
    """A differential drive base and its motor controller."""

    wheel_radius: float = setting(0.033, 'wheel radius', 'm', (0.005, 1.0))
    wheel_separation: float = setting(0.2, 'distance between the centres of the wheels', 'm', (0.02, 5.0))
    ticks_per_revolution: int = setting(1440, 'encoder counts per revolution of a wheel', limits=(4, 1_000_000))
    pid_frame: float = setting(
        0.033, "control period (frame) of the firmware's speed control, the unit of its speeds", 's', (0.001, 1.0)
    )
    auto_stop: float = setting(
        2.0,
        'longest time after the last command at which the firmware stops the motors, that of ROSArduinoBridge',
        's',
        (0.1, 10.0),
    )
    cmd_vel_timeout: float = setting(0.5, 'timeout of cmd_vel, after which the robot brakes', 's', (0.05, 2.0))
    max_linear_velocity: float = setting(0.5, 'maximum linear speed', 'm/s', (0.01, 10.0))
    max_angular_velocity: float = setting(1.5, 'maximum turn rate', 'rad/s', (0.05, 20.0))
    max_linear_acceleration: float = setting(0.5, 'maximum linear acceleration and deceleration', 'm/s^2', (0.01, 20.0))
    max_angular_acceleration: float = setting(3.0, 'maximum angular acceleration', 'rad/s^2', (0.05, 100.0))
    max_linear_jerk: float = setting(
        5.0, 'maximum linear jerk; angular jerk is limited in the same proportion', 'm/s^3', (0.1, 1000.0)
    )
    odometry_noise: float = setting(
        0.01,
        'standard deviation of a wheel distance after one metre; it grows with the square root of the distance',
        'm',
        (0.0001, 1.0),
    )


TICKS_MAX = 32767
"""Maximum speed [ticks per frame]: the firmware reads arguments into 16 bits."""
_VELOCITY_MAX = 1e6  # far above all limits, with finite squares [m/s, rad/s]


@dataclass(frozen=True)
class Velocity:
    """Velocity of the base: linear along x [m/s] and angular, counterclockwise [rad/s], in the base frame."""

    forward: float = 0.0
    turn_rate: float = 0.0


def check_velocity(forward: float, turn_rate: float, topic: str = 'cmd_vel') -> Velocity:
    """Return a commanded velocity; raise a MotorBridgeError if a component is not finite or absurdly large."""
    if not (math.isfinite(forward) and math.isfinite(turn_rate)):
        raise MotorBridgeError(f'{topic} has a velocity that is not finite; check its publisher')
    if max(abs(forward), abs(turn_rate)) > _VELOCITY_MAX:
        raise MotorBridgeError(f'{topic} has a velocity that is implausibly high; check its publisher')
    return Velocity(forward, turn_rate)


class DiffDriveKinematics:
    """Kinematics of two driven wheels on one axis.

    Attributes:
        metres_per_tick: distance per encoder tick [m].
        separation: wheel separation [m].
        frame: control period of the firmware, the unit of its speeds [s].
    """

    def __init__(self, settings: DriveSettings) -> None:
        """Take the dimensions from the settings.

        Raises:
            MotorBridgeError: the maximum speed is less than one tick per frame, or does not fit into 16 bits.
        """
        self._wheel_radius = settings.wheel_radius
        self.metres_per_tick = math.tau * settings.wheel_radius / settings.ticks_per_revolution
        self.separation, self.frame = settings.wheel_separation, settings.pid_frame
        straight_ticks = abs(self.to_wheel_ticks(Velocity(settings.max_linear_velocity, 0.0))[0])
        turning = abs(self.to_wheel_ticks(Velocity(0.0, settings.max_angular_velocity))[0])
        if straight_ticks + turning > TICKS_MAX:
            raise MotorBridgeError(
                f'ticks_per_revolution, wheel_radius and the velocity limits give {straight_ticks + turning:.0f} ticks '
                f'per frame, the controller accepts {TICKS_MAX}; check them'
            )
        if straight_ticks < 1.0:
            raise MotorBridgeError(
                f'ticks_per_revolution, wheel_radius and max_linear_velocity give {straight_ticks:.2g} ticks per '
                'frame, below the resolution of 1; check them'
            )

    def to_wheel_ticks(self, velocity: Velocity) -> tuple[float, float]:
        """Return the speeds of the left and the right wheel: v ∓ ω·b/2 [ticks per frame]."""
        per_speed = self.frame / self.metres_per_tick
        turning = 0.5 * self.separation * velocity.turn_rate
        return per_speed * (velocity.forward - turning), per_speed * (velocity.forward + turning)

    def to_velocity(self, left: float, right: float) -> tuple[float, float]:
        """Return v = r (l + r') / 2 and ω = r (r' - l) / b of the wheel speeds l and r' [rad/s]."""
        return (0.5 * self._wheel_radius * (left + right), self._wheel_radius * (right - left) / self.separation)
