"""ROSArduinoBridge's firmware: protocol, speed control and auto-stop, in externally driven time."""

from __future__ import annotations

from collections.abc import Callable

from motor_bridge.emulator.c_arithmetic import atoi, wrap_signed
from motor_bridge.emulator.command_reader import CommandReader, ReceivedCommand
from motor_bridge.emulator.emulator_settings import EmulatorSettings
from motor_bridge.emulator.wheel_pid import PWM_MAX, PidGains, WheelPid

_END = '\r\n'


class Firmware:
    """Firmware of the microcontroller.

    Attributes:
        time: time of the controller [s].
    """

    def __init__(self, settings: EmulatorSettings, read_counts: Callable[[], tuple[int, int]]) -> None:
        """Start with stopped wheels.

        Args:
            settings: baud rate, period of the speed control and auto-stop.
            read_counts: returns the encoder counts since power on, left and right.
        """
        self._settings, self._read_counts = settings, read_counts
        self.time = 0.0
        self._next_frame = settings.pid_frame
        self._last_command = 0.0
        self.reset()

    def reset(self) -> None:
        """Restart as after power on, with counts of zero."""
        self._reader = CommandReader()
        self._gains = PidGains()
        self._wheels = (WheelPid(), WheelPid())
        self._is_moving = False
        self._zero_encoders()

    @property
    def pwm(self) -> tuple[int, int]:
        """PWM of the left and the right motor, -255 to 255."""
        left, right = self._wheels
        return left.pwm, right.pwm

    @property
    def next_event(self) -> float:
        """Time of the next step of the speed control [s]."""
        return self._next_frame

    def receive(self, data: bytes) -> bytes:
        """Receive bytes and return the replies."""
        commands = filter(None, map(self._reader.take, data))
        return ''.join(self._execute(command) + _END for command in commands).encode()

    def run_to(self, time: float) -> None:
        """Advance to a time not after the next event [s]."""
        self.time = time
        if time >= self._next_frame - 1e-9:
            self._next_frame += self._settings.pid_frame
            if self._is_moving:
                for wheel, count in zip(self._wheels, self._counts(), strict=True):
                    wheel.update(count, self._gains)
        if time - self._last_command > self._settings.auto_stop:
            self._stop()

    def _execute(self, command: ReceivedCommand) -> str:
        match command.letter:
            case 'b':
                return str(self._settings.baud)
            case 'e':
                left, right = self._counts()
                return f'{left} {right}'
            case 'r':
                self._zero_encoders()
                self._stop()
            case 'm':
                self._set_speeds(atoi(command.first), atoi(command.second))
            case 'o':
                self._set_pwm(atoi(command.first), atoi(command.second))
            case 'u':
                numbers = [atoi(part) for part in command.first.split(':') if part]
                self._gains = PidGains(*[*numbers, 0, 0, 0, 0][:4])
            case _:
                return 'Invalid Command'
        return 'OK'

    def _set_speeds(self, left: int, right: int) -> None:
        self._last_command = self.time
        if left == 0 and right == 0:
            self._stop()
            return
        if not self._is_moving:  # speed control restarts from the present counts
            self._restart_wheels()
        self._is_moving = True
        for wheel, target in zip(self._wheels, (left, right), strict=True):
            wheel.target = target

    def _set_pwm(self, left: int, right: int) -> None:
        self._last_command = self.time
        self._stop()
        for wheel, pwm in zip(self._wheels, (left, right), strict=True):
            wheel.pwm = max(-PWM_MAX, min(pwm, PWM_MAX))

    def _stop(self) -> None:
        self._is_moving = False
        self._restart_wheels()

    def _restart_wheels(self) -> None:
        for wheel, count in zip(self._wheels, self._counts(), strict=True):
            wheel.restart(count)

    def _zero_encoders(self) -> None:
        self._origins = self._read_counts()

    def _counts(self) -> tuple[int, int]:
        left, right = (
            wrap_signed(count - origin, 32)
            for count, origin in zip(self._read_counts(), self._origins, strict=True)
        )
        return left, right
