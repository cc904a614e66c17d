"""ROSArduinoBridge's firmware: protocol, speed control and auto-stop, in externally driven time.

Integers are those of C, with 16 and 32 bits. Commands are parsed byte by byte, to emulate lost and corrupted bytes.
The division by ``output_divisor`` of the speed control truncates, so that a wheel settles below its target: with the
usual gains by two ticks per frame, which is 9 % of 22.
"""

from collections.abc import Callable
from dataclasses import dataclass

from shirube_core.settings import setting


@dataclass(frozen=True)
class EmulatorSettings:
    """True dimensions of the robot, its motors, encoders and slip."""

    firmware: str = setting(
        'ros_arduino_bridge',
        'emulated firmware; motor_controller adds checksums and a shorter auto-stop to the other',
        choices=('ros_arduino_bridge', 'motor_controller'),
    )
    baud: int = setting(57600, 'baud rate in the reply to b', 'baud', (1200, 4_000_000))
    wheel_radius: float = setting(0.033, 'true wheel radius', 'm', (0.005, 1.0))
    wheel_separation: float = setting(0.2, 'true distance between the centres of the wheels', 'm', (0.02, 5.0))
    ticks_per_revolution: int = setting(1440, 'encoder counts per revolution of a wheel', limits=(4, 1_000_000))
    wheel_speed_max: float = setting(25.0, 'speed of a wheel at full voltage', 'rad/s', (0.5, 500.0))
    motor_time_constant: float = setting(0.06, 'time in which a wheel reaches 63 % of its speed', 's', (0.001, 5.0))
    motor_dead_band: int = setting(12, 'greatest PWM at which a motor does not turn, of 255', limits=(0, 200))
    slip: float = setting(0.0, 'mean slip of a wheel, fraction of its distance', limits=(-0.5, 0.5))
    slip_sigma: float = setting(0.005, 'standard deviation of the slip after one metre, fraction', limits=(0.0, 0.5))
    encoder_noise: float = setting(0.3, 'standard deviation of a count', 'ticks', (0.0, 100.0))
    pid_frame: float = setting(
        0.0363,
        'true period of the speed control, which assumes 33 ms: so speeds are 9 % below the commands',
        's',
        (0.005, 0.5),
    )
    auto_stop: float = setting(2.0, 'time after the last command at which the motors stop', 's', (0.05, 60.0))
    boot_time: float = setting(1.5, 'time after a reset without reception', 's', (0.0, 30.0))


PWM_MAX = 255
ARGUMENT_MAX = 16
"""Longest argument [bytes]; longer ones are undefined behaviour on the microcontroller."""
_END = '\r\n'


class Firmware:
    """Firmware of the microcontroller.

    Attributes:
        time: time of the controller [s].
    """

    def __init__(self, settings: EmulatorSettings, read_counts: Callable[[], tuple[int, int]]) -> None:
        """Start with stopped wheels; ``read_counts`` returns the encoder counts since power on, left and right."""
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
        self._auto_stop = self._settings.auto_stop
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
        return ''.join(self._execute(*command) + _END for command in commands).encode()

    def run_to(self, time: float) -> None:
        """Advance to a time not after the next event [s]."""
        self.time = time
        if time >= self._next_frame - 1e-9:
            self._next_frame += self._settings.pid_frame
            if self._is_moving:
                for wheel, count in zip(self._wheels, self._counts(), strict=True):
                    wheel.update(count, self._gains)
        if time - self._last_command > self._auto_stop:
            self._stop()

    def _execute(self, letter: str, first: str, second: str) -> str:
        match letter:
            case 'b':
                return str(self._settings.baud)
            case 'e':
                left, right = self._counts()
                return f'{left} {right}'
            case 'r':
                self._zero_encoders()
                self._stop()
            case 'm':
                self._set_speeds(atoi(first), atoi(second))
            case 'o':
                self._set_pwm(atoi(first), atoi(second))
            case 'u':
                numbers = [atoi(part) for part in first.split(':') if part]
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
            wrap_signed(count - origin, 32) for count, origin in zip(self._read_counts(), self._origins, strict=True)
        )
        return left, right


class CommandReader:
    """Collects bytes until a carriage return ends a command.

    A space starts an argument; spaces after the second argument are ignored. Before an argument, the last byte is the
    letter. So ``m 1`` without its carriage return, followed by ``m 10 10``, is parsed as ``m 1 1010``.
    """

    def __init__(self) -> None:
        self._letter, self._arguments = '', list[str]()

    def take(self, byte: int) -> tuple[str, str, str] | None:
        """Add a byte; return letter and two arguments, which may be empty, if the command is complete, else None."""
        character = chr(byte)
        if character == '\r':
            first, second, *_ = [*self._arguments, '', '']
            command = self._letter, first, second
            self._letter, self._arguments = '', []
            return command
        if character == ' ':
            if len(self._arguments) < 2:
                self._arguments.append('')
        elif not self._arguments:
            self._letter = character
        elif len(self._arguments[-1]) < ARGUMENT_MAX:
            self._arguments[-1] += character
        return None


@dataclass(frozen=True)
class PidGains:
    """Gains of the command ``u P:D:I:O``."""

    proportional: int = 20
    derivative: int = 12
    integral: int = 0
    output_divisor: int = 50


class WheelPid:
    """Controls the speed of one wheel.

    Attributes:
        target: target speed [ticks per frame].
        pwm: PWM of the motor, -255 to 255.
    """

    def __init__(self) -> None:
        self.restart(0)

    def restart(self, count: int) -> None:
        """Reset the controller with the wheel at a count."""
        self.target = self.pwm = 0
        self._previous_count, self._previous_input, self._integral_term = count, 0, 0

    def update(self, count: int, gains: PidGains) -> None:
        """Run one control period with the current encoder count [ticks]."""
        moved = wrap_signed(count - self._previous_count, 16)
        error = self.target - moved
        term = gains.proportional * error - gains.derivative * (moved - self._previous_input)
        output = self.pwm + divide_truncating(term + self._integral_term, gains.output_divisor)
        if -PWM_MAX < output < PWM_MAX:
            self._integral_term = wrap_signed(self._integral_term + gains.integral * error, 16)
        self.pwm = max(-PWM_MAX, min(output, PWM_MAX))
        self._previous_count, self._previous_input = count, moved


def wrap_signed(value: int, bits: int) -> int:
    """Wrap an integer to a signed one of ``bits`` bits."""
    half = 1 << (bits - 1)
    return (value + half) % (2 * half) - half


def divide_truncating(numerator: int, denominator: int) -> int:
    """Return the quotient truncated towards zero; 0 for a division by zero, which raises no error on AVR."""
    if denominator == 0:
        return 0
    quotient = abs(numerator) // abs(denominator)
    return quotient if (numerator < 0) == (denominator < 0) else -quotient


def atoi(text: str) -> int:
    """Return the 16-bit integer at the start of a text, 0 if there is none: ``nan`` is 0, ``1e3`` is 1."""
    stripped = text.lstrip(' \t\n\v\f\r')
    sign = -1 if stripped.startswith('-') else 1
    value = 0
    for character in stripped[1:] if stripped[:1] in ('-', '+') else stripped:
        if character not in '0123456789':
            break
        value = 10 * value + int(character)
    return wrap_signed(sign * value, 16)
