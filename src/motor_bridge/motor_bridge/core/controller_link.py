"""Protocol client of the motor controller: one command at a time, every reply is checked."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Protocol

from motor_bridge.core.serial_protocol import (
    END_OF_COMMAND,
    READ_BAUD,
    READ_ENCODERS,
    REPLY_MAX,
    STOP,
    BadReplyError,
    NoReplyError,
    WheelCounts,
    check_acknowledged,
    gains_request,
    parse_baud,
    parse_counts,
    speeds_request,
)


class SerialLine(Protocol):
    """A serial line."""

    def write(self, data: bytes) -> None:
        """Send bytes."""

    def read_line(self, size_max: int) -> bytes:
        """Return bytes up to a line feed, at most ``size_max``, or fewer after the reply timeout."""

    def drain(self) -> int:
        """Discard received bytes until the line is quiet; return their number."""

    def discard_received(self) -> int:
        """Discard received bytes without waiting; return their number."""


@dataclass(frozen=True)
class ControllerSetup:
    """Settings that are checked or sent at the handshake.

    Attributes:
        baud: baud rate, which the controller must confirm.
        gains: proportional, derivative and integral gain and divisor of the speed control.
    """

    baud: int
    gains: tuple[int, int, int, int]


class ControllerLink:
    """Sends commands to a controller and checks its replies.

    Attributes:
        unsolicited_bytes: number of bytes received without a command.
    """

    def __init__(self, line: SerialLine, setup: ControllerSetup) -> None:
        """Start before the handshake."""
        self._line, self._setup = line, setup
        self.unsolicited_bytes = 0

    def handshake(self) -> WheelCounts:
        """Handshake: stop the motors, check the baud rate, set the gains and return the encoder counts.

        A carriage return ends partial commands from noise. A hung controller may have a pending command, so the stop is
        sent right behind it without waiting for a reply.

        Raises:
            LinkError: no reply or an invalid one.
        """
        self._line.write(END_OF_COMMAND + STOP)
        self._line.drain()
        baud = parse_baud(self._transact(READ_BAUD))
        if baud != self._setup.baud:
            raise BadReplyError(
                f'the controller uses {baud} baud, parameter baud is {self._setup.baud}; make them equal'
            )
        check_acknowledged(self._transact(gains_request(*self._setup.gains)))
        counts = self.read_counts()
        self.stop()
        return counts

    def set_speeds(self, left: int, right: int) -> None:
        """Set the wheel speeds [ticks per frame].

        Raises:
            LinkError: no reply or an invalid one.
        """
        check_acknowledged(self._transact(speeds_request(left, right)))

    def stop(self) -> None:
        """Stop the motors.

        Raises:
            LinkError: no reply or an invalid one.
        """
        check_acknowledged(self._transact(STOP))

    def stop_and_resynchronize(self) -> None:
        """End partial commands on the line, then stop the motors.

        Raises:
            LinkError: no reply or an invalid one.
        """
        self._line.write(END_OF_COMMAND + STOP)
        self._line.drain()
        self.stop()

    def read_counts(self) -> WheelCounts:
        """Read the encoder counts.

        Raises:
            LinkError: no reply or an invalid one.
        """
        return parse_counts(self._transact(READ_ENCODERS))

    def resynchronize(self) -> None:
        """Resynchronize after an invalid reply: end partial commands and discard partial replies."""
        self._line.write(END_OF_COMMAND)
        self.unsolicited_bytes += self._line.drain()

    def _transact(self, request: bytes) -> bytes:
        self.unsolicited_bytes += self._line.discard_received()
        self._line.write(request)
        reply = self._line.read_line(REPLY_MAX)
        if not reply.endswith(b'\n') and len(reply) < REPLY_MAX:
            name = request.decode().strip()
            raise NoReplyError(f'the controller does not reply to {name!r}; check cable and power')
        return reply
