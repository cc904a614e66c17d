"""Client of ROSArduinoBridge's protocol: one command at a time, every reply is checked.

A command is a letter and its arguments, ended by a carriage return, with one reply.
A line feed would become the letter of the next command, so none is sent. The protocol has no checksum: a reply is
accepted only if it has exactly the expected format.
"""

from __future__ import annotations

import re
from dataclasses import dataclass
from typing import Protocol

from motor_bridge.core.diff_drive_kinematics import TICKS_MAX
from motor_bridge.core.motor_bridge_error import MotorBridgeError

END_OF_COMMAND = b'\r'
"""Sent alone, it ends a partial command from noise or a killed program."""
READ_ENCODERS = b'e\r'
READ_BAUD = b'b\r'
STOP = b'm 0 0\r'
REPLY_MAX = 64
"""Longest reply [bytes]."""
_COUNTS = re.compile(rb'(-?\d{1,10}) (-?\d{1,10})\r\n')
_COUNT_MIN, _COUNT_MAX = -(2**31), 2**31 - 1
_SHOWN_MAX = 40


class LinkError(MotorBridgeError):
    """No reply or an invalid one."""


class NoReplyError(LinkError):
    """No complete reply within the timeout."""


class BadReplyError(LinkError):
    """A reply has an unexpected format."""


@dataclass(frozen=True)
class WheelCounts:
    """Counts of both encoders, signed 32 bits [ticks]."""

    left: int
    right: int


def speeds_request(left: int, right: int) -> bytes:
    """Return the command that sets both wheel speeds [ticks per frame].

    Raises:
        MotorBridgeError: a speed does not fit into 16 bits; the controller would drive full reverse.
    """
    if max(abs(left), abs(right)) > TICKS_MAX:
        raise MotorBridgeError(f'{left} and {right} ticks per frame are too many; at most {TICKS_MAX}')
    return f'm {left} {right}\r'.encode()


def gains_request(proportional: int, derivative: int, integral: int, divisor: int) -> bytes:
    """Return the command that sets the gains of the speed control."""
    return f'u {proportional}:{derivative}:{integral}:{divisor}\r'.encode()


def check_acknowledged(reply: bytes) -> None:
    """Check the reply to a command that returns no value: ``OK``."""
    if reply != b'OK\r\n':
        raise _bad_reply(reply, 'OK')


def parse_baud(reply: bytes) -> int:
    """Parse the reply to ``b``, the baud rate."""
    if not re.fullmatch(rb'\d{3,7}\r\n', reply):
        raise _bad_reply(reply, 'a baud rate')
    return int(reply)


def parse_counts(reply: bytes) -> WheelCounts:
    r"""Parse the reply to ``e``, the encoder counts: ``^-?\d+ -?\d+\r\n$``.

    Raises:
        BadReplyError: another format, or a count that does not fit into 32 bits.
    """
    match = _COUNTS.fullmatch(reply)
    if match is None:
        raise _bad_reply(reply, 'two counts')
    counts = WheelCounts(int(match[1]), int(match[2]))
    if not all(_COUNT_MIN <= count <= _COUNT_MAX for count in (counts.left, counts.right)):
        raise _bad_reply(reply, 'two counts of 32 bits')
    return counts


def _bad_reply(reply: bytes, expected: str) -> BadReplyError:
    shown = reply[:_SHOWN_MAX].decode('ascii', 'backslashreplace').encode('unicode_escape').decode()
    remedy = 'check wiring and noise'
    if reply == b'Invalid Command\r\n':
        remedy += ', and whether its firmware accepts speeds of so many ticks per frame'
    return BadReplyError(f"the controller replies '{shown}' instead of {expected}; {remedy}")


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
        """Set the wheel speeds [ticks per frame]; errors as for `stop`."""
        check_acknowledged(self._transact(speeds_request(left, right)))

    def stop(self) -> None:
        """Stop the motors.

        Raises:
            LinkError: no reply or an invalid one.
        """
        check_acknowledged(self._transact(STOP))

    def stop_and_resynchronize(self) -> None:
        """End partial commands on the line, then stop the motors; errors as for `stop`."""
        self._line.write(END_OF_COMMAND + STOP)
        self._line.drain()
        self.stop()

    def read_counts(self) -> WheelCounts:
        """Read the encoder counts; errors as for `stop`."""
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
