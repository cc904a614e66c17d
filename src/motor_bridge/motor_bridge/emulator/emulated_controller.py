"""Emulated motor controller and robot, in externally driven time."""

import math
import re
from bisect import bisect_right

import numpy as np

from motor_bridge.core.controller_protocol import with_checksum, without_checksum
from motor_bridge.core.motor_bridge_error import MotorBridgeError
from motor_bridge.emulator.firmware import PWM_MAX, EmulatorSettings, Firmware
from shirube_core.geometry import SE2

_AUTO_STOP = 200, 2000  # range [ms]


class ChecksummedFirmware(Firmware):
    """Firmware that replies with checksums from the first valid one on, and then refuses plain lines."""

    def reset(self) -> None:
        """Restart as after power on: without checksums."""
        super().reset()
        self._partial_line, self._is_checksummed = b'', False

    def receive(self, data: bytes) -> bytes:
        """Receive bytes and return the replies."""
        *lines, self._partial_line = (self._partial_line + data).split(b'\r')
        return b''.join(map(self._reply, lines))

    def _reply(self, line: bytes) -> bytes:
        text = without_checksum(line) if b'*' in line else line
        if text is not line:
            self._is_checksummed |= text is not None
        elif self._is_checksummed and line != b'm 0 0':
            self._is_checksummed = line != b'b'
            text = None if self._is_checksummed else line
        auto_stop = re.fullmatch(rb'h (\d{1,5})', text or b'')
        if auto_stop and _AUTO_STOP[0] <= int(auto_stop[1]) <= _AUTO_STOP[1]:
            self._auto_stop, reply = 1e-3 * int(auto_stop[1]), b'OK'
        else:
            reply = super().receive((text or b'') + b'\r').removesuffix(b'\r\n')
        return (with_checksum(reply) if self._is_checksummed else reply) + b'\r\n'


_STEP = 0.005  # longest simulation step [s]
_HISTORY_MAX = 120_000  # poses to keep: ten minutes
_STOPPED_SPEED = 1e-2  # below this a wheel counts as stopped [rad/s]
_COASTING_SPEED_MIN = 1e-3  # below this a wheel without voltage stops [rad/s]
_ORIGIN = SE2(0.0, 0.0, 0.0)


class EmulatedController:
    """Executes the firmware's protocol and simulates the robot.

    Attributes:
        time: simulated time [s].
    """

    def __init__(self, settings: EmulatorSettings, rng: np.random.Generator, start: SE2 = _ORIGIN) -> None:
        """Start at rest at time 0, at the pose ``start`` in the world; the generator gives slip and noise."""
        self._settings = settings
        self._body = RobotModel(settings, rng, start)
        make_firmware = ChecksummedFirmware if settings.firmware == 'motor_controller' else Firmware
        self._firmware = make_firmware(settings, self._body.read_counts)
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
        """Return ``T_world_base`` at a time [s] until now, at the earliest that of the start."""
        if time > self.time + 1e-9:
            raise MotorBridgeError(f'the robot is simulated until {self.time} s, not until {time} s')
        after = bisect_right(self._times, time)
        if after == 0 or after == len(self._times):
            return self._poses[min(after, len(self._poses) - 1)]
        fraction = (time - self._times[after - 1]) / (self._times[after] - self._times[after - 1])
        here, step = self._poses[after - 1], self._poses[after - 1].inverse() @ self._poses[after]
        return here @ SE2(fraction * step.x, fraction * step.y, fraction * step.yaw)


class RobotModel:
    """A differential drive robot: motors, wheels and slip.

    Attributes:
        T_world_base: true pose of the robot.
        wheel_speeds: speeds of the left and the right wheel [rad/s].
        wheel_angles: angles of the left and the right wheel since the start [rad].
    """

    def __init__(self, settings: EmulatorSettings, rng: np.random.Generator, start: SE2) -> None:
        self._settings, self._rng = settings, rng
        self.T_world_base = start
        self.wheel_speeds = (0.0, 0.0)
        self.wheel_angles = (0.0, 0.0)

    def move(self, pwm: tuple[int, int], elapsed: float) -> None:
        """Simulate a short time step [s] with the PWM of both motors, -255 to 255."""
        before = self.wheel_speeds
        left, right = (self._next_speed(s, p, elapsed) for s, p in zip(before, pwm, strict=True))
        self.wheel_speeds = left, right
        turned = 0.5 * elapsed * (before[0] + left), 0.5 * elapsed * (before[1] + right)
        self.wheel_angles = self.wheel_angles[0] + turned[0], self.wheel_angles[1] + turned[1]
        if turned != (0.0, 0.0):
            self._roll(*(self._settings.wheel_radius * angle for angle in turned))

    def read_counts(self) -> tuple[int, int]:
        """Return the noisy encoder counts since the start."""
        per_radian = self._settings.ticks_per_revolution / math.tau
        sigma = self._settings.encoder_noise
        noise = self._rng.normal(0.0, sigma, 2) if sigma else (0.0, 0.0)
        left, right = (round(per_radian * a + n) for a, n in zip(self.wheel_angles, noise, strict=True))
        return left, right

    def _next_speed(self, speed: float, pwm: int, elapsed: float) -> float:
        settings = self._settings
        target = 0.0 if abs(pwm) <= settings.motor_dead_band else settings.wheel_speed_max * pwm / PWM_MAX
        after = target + (speed - target) * math.exp(-elapsed / settings.motor_time_constant)
        return 0.0 if target == 0.0 and abs(after) < _COASTING_SPEED_MIN else after

    def _roll(self, *distances: float) -> None:
        """Move the robot by the distances of its wheels [m], minus slip."""
        settings, sigma = self._settings, self._settings.slip_sigma
        left, right = (
            (1.0 - settings.slip) * distance + (sigma * math.sqrt(abs(distance)) * self._rng.normal() if sigma else 0.0)
            for distance in distances
        )
        forward, turn = 0.5 * (left + right), (right - left) / settings.wheel_separation
        self.T_world_base = self.T_world_base @ SE2.exp(forward, 0.0, turn)
