"""The firmware of the motor controller in simavr, with two motors and their encoders."""

import subprocess
from dataclasses import dataclass
from pathlib import Path

from simulated_chip import SimulatedChip

FRAME_SECONDS = 0.033
RAM_OFFSET = 0x800000


@dataclass(frozen=True)
class Truth:
    """What the motors do, left and right.

    Attributes:
        seconds: since power on.
        ticks: that the encoders have made since power on.
        pwm: at the motor driver's inputs, -255 to 255.
        resets: since power on.
    """

    seconds: float
    ticks: tuple[int, int]
    pwm: tuple[int, int]
    resets: int


class SimulatedMotorController(SimulatedChip):
    """A motor controller whose motors reach 3000 ticks/s and follow with a lag of 0.1 s.

    Args:
        build: folder of `build_firmware`.
    """

    def __init__(self, build: Path) -> None:
        self._elf = build / 'motor_controller.elf'
        super().__init__(build, self._elf)

    def truth(self) -> Truth:
        """Return what the motors do now."""
        self._command('w')
        microseconds, *numbers = (int(word) for word in self._answer().split())
        left, right, left_pwm, right_pwm, resets = numbers
        return Truth(microseconds * 1e-6, (left, right), (left_pwm, right_pwm), resets)

    def counts(self) -> tuple[int, int]:
        """Return what it answers when it is asked for the encoders."""
        left, right = self.ask('e').split()
        return int(left), int(right)

    def counts_at_rest(self) -> tuple[int, int]:
        """Stop the motors and return the counts of the encoders."""
        self.ask('o 0 0')
        self.run(1.0)
        return self.counts()

    def set_motors(self, left: float, right: float, lag: float) -> None:
        """Change the speeds at full PWM [ticks/s] and the lag [s]."""
        self._command(f't {left} {right} {lag * 1000}')

    def set_counts(self, count: int) -> None:
        """Let both encoders have counted so far."""
        symbols = subprocess.run(['avr-nm', self._elf], check=True, capture_output=True, text=True).stdout
        address = next(line.split()[0] for line in symbols.splitlines() if line.endswith(' counts'))
        both = 2 * count.to_bytes(4, 'little', signed=True)
        self._command(f'k {int(address, 16) - RAM_OFFSET} {both.hex()}')

    def hang(self) -> None:
        """Let the program jump to itself from here on, until the next reset."""
        self._command('h')

    def drive(self, order: str, seconds: float) -> None:
        """Repeat an order as a host does, so that it does not end by itself."""
        end = self.truth().seconds + seconds
        while end - self.truth().seconds > 1e-6:
            assert self.ask(order) == 'OK'
            self.run(min(0.5, max(0.0, end - self.truth().seconds)))

    def until_pwm(self, *, is_on: bool, within: float) -> float:
        """Let time pass until the motors are on or off, and return when that was [s]."""
        last = self.truth().seconds + within
        while any((now := self.truth()).pwm) != is_on:
            assert now.seconds < last, f'the motors are {"off" if is_on else "on"} for {within} s'
            self.run(1e-4)
        return now.seconds
