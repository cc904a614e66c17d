"""A motor controller with a robot around it, in a time that it is given."""

from __future__ import annotations

from bisect import bisect_right

import numpy as np

from motor_bridge.core.motor_bridge_error import MotorBridgeError
from motor_bridge.emulator.driven_body import DrivenBody
from motor_bridge.emulator.emulator_settings import EmulatorSettings
from motor_bridge.emulator.firmware import Firmware
from shirube_geometry import PlanarPose

_STEP = 0.005  # longest time in which the motors' voltages are held [s]
_HISTORY_MAX = 120_000  # steps; ten minutes
_STOPPED = 1e-2  # wheels that are slower stand [rad/s]
_ORIGIN = PlanarPose(0.0, 0.0, 0.0)


class EmulatedController:
    """Speaks the firmware's protocol and drives a robot.

    Attributes:
        time: until when the robot has been driven [s].
    """

    def __init__(
        self, settings: EmulatorSettings, rng: np.random.Generator, start: PlanarPose = _ORIGIN
    ) -> None:
        """Put the robot at rest at time 0.

        Args:
            settings: of the controller and the robot.
            rng: source of slip and noise.
            start: ``T_world_base`` at time 0.
        """
        self._settings = settings
        self._body = DrivenBody(settings, rng, start)
        self._firmware = Firmware(settings, self._body.read_counts)
        self._hears_from = 0.0
        self._times, self._poses = [0.0], [start]

    @property
    def time(self) -> float:
        """Until when the robot has been driven [s]."""
        return self._times[-1]

    @property
    def T_world_base(self) -> PlanarPose:  # noqa: N802 the field's name for it
        """The true pose now."""
        return self._poses[-1]

    @property
    def wheel_speeds(self) -> tuple[float, float]:
        """True speeds of the left and the right wheel [rad/s]."""
        return self._body.wheel_speeds

    @property
    def is_stopped(self) -> bool:
        """Whether both motors are without voltage and both wheels stand."""
        return self._firmware.pwm == (0, 0) and max(map(abs, self.wheel_speeds)) < _STOPPED

    def receive(self, data: bytes) -> bytes:
        """Take what came over the line now; return the replies."""
        return self._firmware.receive(data) if self.time >= self._hears_from else b''

    def reset(self) -> None:
        """Start the controller again, as its button does: the motors are off, the counts zero, it is deaf at first."""
        self._firmware.reset()
        self._hears_from = self.time + self._settings.boot_time

    def advance(self, until: float) -> None:
        """Let time pass [s]; a time in the past changes nothing."""
        while self.time < until - 1e-12:
            step_end = min(until, self.time + _STEP, max(self._firmware.next_event, self.time + 1e-6))
            self._body.move(self._firmware.pwm, step_end - self.time)
            self._times.append(step_end)
            self._poses.append(self._body.T_world_base)
            self._firmware.run_to(step_end)
        if len(self._times) > 2 * _HISTORY_MAX:
            del self._times[:_HISTORY_MAX], self._poses[:_HISTORY_MAX]

    def pose_at(self, time: float) -> PlanarPose:
        """Return ``T_world_base`` at a time [s]; before the start it is that of the start.

        Raises:
            MotorBridgeError: a time up to which the robot has not been driven.
        """
        if time > self.time + 1e-9:
            raise MotorBridgeError(f'the robot has been driven until {self.time} s, not until {time} s')
        after = bisect_right(self._times, time)
        if after == 0 or after == len(self._times):
            return self._poses[min(after, len(self._poses) - 1)]
        share = (time - self._times[after - 1]) / (self._times[after] - self._times[after - 1])
        here, step = self._poses[after - 1], self._poses[after - 1].inverse() @ self._poses[after]
        return here @ PlanarPose(share * step.x, share * step.y, share * step.yaw)
