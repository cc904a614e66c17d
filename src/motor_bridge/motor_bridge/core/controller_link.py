"""The conversation with the motor controller: one command in flight, every reply checked."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Protocol

from motor_bridge.core.serial_protocol import (
    ASK_BAUD,
    END_OF_COMMAND,
    READ_ENCODERS,
    REPLY_MAX,
    STOP,
    BadReplyError,
    NoReplyError,
    WheelCounts,
    check_done,
    gains_request,
    read_baud,
    read_counts,
    speeds_request,
)


class Line(Protocol):
    """A serial line."""

    def write(self, data: bytes) -> None:
        """Send bytes."""

    def read_line(self, size_max: int) -> bytes:
        """Return bytes up to a line feed, or fewer: those that came in the time of a reply, or ``size_max``."""

    def drain(self) -> int:
        """Drop what came unasked and what still comes, until the line is quiet; return how much [bytes]."""

    def drop_received(self) -> int:
        """Drop what came unasked, without waiting; return how much [bytes]."""


@dataclass(frozen=True)
class ControllerSetup:
    """What a controller is told at first.

    Attributes:
        baud: rate of the line, which the controller must confirm.
        gains: proportional, derivative, integral and divisor of its speed control.
    """

    baud: int
    gains: tuple[int, int, int, int]


class ControllerLink:
    """Speaks with a controller.

    Attributes:
        unasked: bytes that came without a question.
    """

    def __init__(self, line: Line, setup: ControllerSetup) -> None:
        """Speak to nobody yet."""
        self._line, self._setup = line, setup
        self.unasked = 0

    def greet(self) -> WheelCounts:
        """Find the controller, stop its motors, set it up and return its counts.

        A carriage return ends what noise began. A controller that hung still has a command before it: the stop is sent
        along without waiting, so that it comes right behind.

        Raises:
            LinkError: it does not answer as it must.
        """
        self._line.write(END_OF_COMMAND + STOP)
        self._line.drain()
        baud = read_baud(self._ask(ASK_BAUD))
        if baud != self._setup.baud:
            raise BadReplyError(
                f'the controller works at {baud} baud, parameter baud is {self._setup.baud}; make them the same'
            )
        check_done(self._ask(gains_request(*self._setup.gains)))
        counts = self.read_counts()
        self.stop()
        return counts

    def set_speeds(self, left: int, right: int) -> None:
        """Set the wheels' speeds [ticks a frame].

        Raises:
            LinkError: the controller does not confirm it.
        """
        check_done(self._ask(speeds_request(left, right)))

    def stop(self) -> None:
        """Stop the motors.

        Raises:
            LinkError: the controller does not confirm it.
        """
        check_done(self._ask(STOP))

    def leave(self) -> None:
        """Stop the motors for good, even if half a command is before the stop.

        Raises:
            LinkError: the controller does not confirm it.
        """
        self._line.write(END_OF_COMMAND + STOP)
        self._line.drain()
        self.stop()

    def read_counts(self) -> WheelCounts:
        """Return the encoders' counts.

        Raises:
            LinkError: the controller does not tell them.
        """
        return read_counts(self._ask(READ_ENCODERS))

    def find_step(self) -> None:
        """After a bad reply: end what may be half a command, and drop what may be half a reply."""
        self._line.write(END_OF_COMMAND)
        self.unasked += self._line.drain()

    def _ask(self, request: bytes) -> bytes:
        self.unasked += self._line.drop_received()
        self._line.write(request)
        reply = self._line.read_line(REPLY_MAX)
        if not reply.endswith(b'\n') and len(reply) < REPLY_MAX:
            name = request.decode().strip()
            raise NoReplyError(f'the controller does not answer to {name!r}; check cable and power')
        return reply
