"""Velocities of the base to speeds of its wheels and back, in the units of the motor controller."""

from __future__ import annotations

import math

from motor_bridge.core.drive_settings import DriveSettings
from motor_bridge.core.motor_bridge_error import MotorBridgeError
from motor_bridge.core.velocity import Velocity

TICKS_MAX = 32767
"""Of one frame: the firmware reads arguments into 16 bits."""


class WheelBase:
    """Two driven wheels on one axis.

    Attributes:
        metres_per_tick: way of a wheel while its encoder counts one.
        separation: of the wheels [m].
        frame: in which the controller counts speeds [s].
    """

    def __init__(self, settings: DriveSettings) -> None:
        """Take the dimensions over.

        Raises:
            MotorBridgeError: wheels that could not even move at the greatest speed, or that the controller's 16 bits
                could not follow.
        """
        self.metres_per_tick = math.tau * settings.wheel_radius / settings.ticks_per_revolution
        self.separation, self.frame = settings.wheel_separation, settings.pid_frame
        fastest = abs(self.ticks_of(Velocity(settings.max_linear_velocity, 0.0))[0])
        turning = abs(self.ticks_of(Velocity(0.0, settings.max_angular_velocity))[0])
        if fastest + turning > TICKS_MAX:
            raise MotorBridgeError(
                f'ticks_per_revolution, wheel_radius and the greatest velocities make {fastest + turning:.0f} ticks a '
                f'frame, the controller takes {TICKS_MAX}; check them'
            )
        if fastest < 1.0:
            raise MotorBridgeError(
                f'ticks_per_revolution, wheel_radius and max_linear_velocity make {fastest:.2g} ticks a frame, less '
                'than the controller can tell from none; check them'
            )

    def ticks_of(self, velocity: Velocity) -> tuple[float, float]:
        """Return the speeds of the left and the right wheel: v ∓ ω·b/2 [ticks a frame]."""
        per_speed = self.frame / self.metres_per_tick
        turning = 0.5 * self.separation * velocity.turn_rate
        return per_speed * (velocity.forward - turning), per_speed * (velocity.forward + turning)

    def velocity_of(self, left: float, right: float) -> Velocity:
        """Return the velocity that belongs to speeds of the wheels [ticks a frame]; the inverse of `ticks_of`."""
        per_tick = self.metres_per_tick / self.frame
        return Velocity(0.5 * per_tick * (left + right), per_tick * (right - left) / self.separation)
