"""The firmware's speed controller of one wheel, in integers as on the microcontroller.

The division by ``output_divisor`` truncates, so that a wheel settles below its target: with the usual gains by two
ticks per frame, which is 9 % of 22.
"""

from __future__ import annotations

from dataclasses import dataclass

from motor_bridge.emulator.c_arithmetic import divide_truncating, wrap_signed

PWM_MAX = 255


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
        """Start stopped at count 0."""
        self.restart(0)

    def restart(self, count: int) -> None:
        """Reset the controller with the wheel at a count."""
        self.target = 0
        self.pwm = 0
        self._previous_count = count
        self._previous_input = 0
        self._integral_term = 0

    def update(self, count: int, gains: PidGains) -> None:
        """Run one control period.

        Args:
            count: current encoder count [ticks].
            gains: gains of the control law.
        """
        moved = wrap_signed(count - self._previous_count, 16)
        error = self.target - moved
        term = gains.proportional * error - gains.derivative * (moved - self._previous_input)
        output = self.pwm + divide_truncating(term + self._integral_term, gains.output_divisor)
        if -PWM_MAX < output < PWM_MAX:
            self._integral_term = wrap_signed(self._integral_term + gains.integral * error, 16)
        self.pwm = max(-PWM_MAX, min(output, PWM_MAX))
        self._previous_count, self._previous_input = count, moved
