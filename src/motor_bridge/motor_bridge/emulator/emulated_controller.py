"""Emulated motor controller and robot, in externally driven time."""

from __future__ import annotations

from bisect import bisect_right

import numpy as np

from motor_bridge.core.motor_bridge_error import MotorBridgeError
from motor_bridge.emulator.emulator_settings import EmulatorSettings
from motor_bridge.emulator.firmware import Firmware
from motor_bridge.emulator.robot_model import RobotModel
from shirube_core.geometry import SE2

_STEP = 0.005  # longest simulation step [s]
_HISTORY_MAX = 120_000  # poses to keep: ten minutes
_STOPPED_SPEED = 1e-2  # below this a wheel counts as stopped [rad/s]
_ORIGIN = SE2(0.0, 0.0, 0.0)


class EmulatedController:
    """Executes the firmware's protocol and simulates the robot.

    Attributes:
        time: simulated time [s].
    """

    def __init__(self, settings: EmulatorSettings, rng: np.random.Generator, start: SE2 = _ORIGIN) -> None:
        """Start at rest at time 0.

        Args:
            settings: settings of the controller and the robot.
            rng: random generator of slip and noise.
            start: ``T_world_base`` at time 0.
        """
        self._settings = settings
        self._body = RobotModel(settings, rng, start)
        self._firmware = Firmware(settings, self._body.read_counts)
        self._boot_end = 0.0
        self._times, self._poses = [0.0], [start]

    @property
    def time(self) -> float:
        """Simulated time [s]."""
        return self._times[-1]

    @property
    def T_world_base(self) -> SE2:  # noqa: N802 the field's name for it
        """True pose now."""
        return self._poses[-1]

    @property
    def wheel_speeds(self) -> tuple[float, float]:
        """True speeds of the left and the right wheel [rad/s]."""
        return self._body.wheel_speeds

    @property
    def is_stopped(self) -> bool:
        """Whether both motors are without voltage and both wheels are stopped."""
        return self._firmware.pwm == (0, 0) and max(map(abs, self.wheel_speeds)) < _STOPPED_SPEED

    def receive(self, data: bytes) -> bytes:
        """Receive bytes; return the replies."""
        return self._firmware.receive(data) if self.time >= self._boot_end else b''

    def reset(self) -> None:
        """Reset the controller: motors off, counts zero, no input until it has booted."""
        self._firmware.reset()
        self._boot_end = self.time + self._settings.boot_time

    def advance(self, until: float) -> None:
        """Simulate until a time [s]; a time in the past changes nothing."""
        while self.time < until - 1e-12:
            step_end = min(until, self.time + _STEP, max(self._firmware.next_event, self.time + 1e-6))
            self._body.move(self._firmware.pwm, step_end - self.time)
            self._times.append(step_end)
            self._poses.append(self._body.T_world_base)
            self._firmware.run_to(step_end)
        if len(self._times) > 2 * _HISTORY_MAX:
            del self._times[:_HISTORY_MAX], self._poses[:_HISTORY_MAX]

    def pose_at(self, time: float) -> SE2:
        """Return ``T_world_base`` at a time [s], at the earliest that of the start.

        Raises:
            MotorBridgeError: the time is after the simulated time.
        """
        if time > self.time + 1e-9:
            raise MotorBridgeError(f'the robot is simulated until {self.time} s, not until {time} s')
        after = bisect_right(self._times, time)
        if after == 0 or after == len(self._times):
            return self._poses[min(after, len(self._poses) - 1)]
        fraction = (time - self._times[after - 1]) / (self._times[after] - self._times[after - 1])
        here, step = self._poses[after - 1], self._poses[after - 1].inverse() @ self._poses[after]
        return here @ SE2(fraction * step.x, fraction * step.y, fraction * step.yaw)
