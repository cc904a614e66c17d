"""Client of ROSArduinoBridge's protocol: one command at a time, every reply is checked.

A command is a letter and its arguments, ended by a carriage return, with one reply.
A line feed would become the letter of the next command, so none is sent. A reply is accepted only if it has exactly the
expected format. The protocol has no checksum, but firmware/motor_controller accepts and sends them if the host does.
"""

import math
import re

from motor_bridge.core.controller_protocol import (
    BadReplyError,
    ControllerSetup,
    NoReplyError,
    SerialLine,
    WheelCounts,
    with_checksum,
    without_checksum,
)
from motor_bridge.core.diff_drive_kinematics import TICKS_MAX
from motor_bridge.core.motor_bridge_error import MotorBridgeError

END_OF_COMMAND = b'\r'
"""Sent alone, it ends a partial command from noise or a killed program."""
READ_ENCODERS = b'e\r'
READ_BAUD = b'b\r'
STOP = b'm 0 0\r'
INVALID = b'Invalid Command\r\n'
REPLY_MAX = 64
"""Longest reply [bytes]."""
_COUNTS = re.compile(rb'(-?\d{1,10}) (-?\d{1,10})\r\n')
_COUNT_MIN, _COUNT_MAX = -(2**31), 2**31 - 1
_SHOWN_MAX = 40
_PROBES = 2  # noise on the first one must not give up the checksums
_AUTO_STOP = 0.2, 2.0  # range of the firmware [s]
_AUTO_STOP_REPLIES = 6.0  # least auto-stop in replies: speeds and counts take two of them per cycle


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
    if reply == INVALID:
        remedy += ', and whether its firmware accepts speeds of so many ticks per frame'
    return BadReplyError(f"the controller replies '{shown}' instead of {expected}; {remedy}")


class RosArduinoBridge:
    """Sends commands to a controller and checks its replies; implements `ControllerProtocol`.

    Attributes:
        name: protocol and options in use.
        auto_stop: auto-stop of the controller [s]; infinite if it cannot be set, as then it is not known.
    """

    def __init__(self, line: SerialLine, setup: ControllerSetup) -> None:
        self._line, self._setup = line, setup
        self._has_checksum = False
        self.name, self.auto_stop = 'ROSArduinoBridge', math.inf

    def connect(self, latency: float) -> WheelCounts:
        """Stop the motors, check the baud rate, set gains and auto-stop, and return the encoder counts.

        A carriage return ends partial commands from noise. A hung controller may have a pending command, so the stop is
        sent right behind it without waiting for a reply. Late replies are dropped until the line is quiet for a
        ``latency`` [s].

        Raises:
            LinkError: no reply or an invalid one.
        """
        self._line.set_latency(latency)
        self._line.write(END_OF_COMMAND + STOP)
        self._line.drain()
        self._negotiate()
        baud = parse_baud(self._transact(READ_BAUD))
        if baud != self._setup.baud:
            raise BadReplyError(
                f'the controller uses {baud} baud, parameter baud is {self._setup.baud}; make them equal'
            )
        check_acknowledged(self._transact(gains_request(*self._setup.gains)))
        counts = self.read_counts()
        self._set_auto_stop(max(self._setup.auto_stop, _AUTO_STOP_REPLIES * self._line.slowest_reply))
        self.stop()
        return counts

    def _negotiate(self) -> None:
        """Use checksums if the controller knows them.

        To ROSArduinoBridge a hexadecimal digit at the end is the letter of a command that does not exist.
        """
        for _ in range(_PROBES):
            self._has_checksum = self._exchange(with_checksum(READ_BAUD[:-1]) + END_OF_COMMAND) != INVALID
            if self._has_checksum:
                break

    def _set_auto_stop(self, wanted: float) -> None:
        self.name, self.auto_stop = 'ROSArduinoBridge', math.inf
        if self._has_checksum:
            milliseconds = round(1e3 * max(_AUTO_STOP[0], min(wanted, _AUTO_STOP[1])))
            check_acknowledged(self._transact(f'h {milliseconds}\r'.encode()))
            self.auto_stop = 1e-3 * milliseconds
            self.name += f' with checksums, auto-stop {self.auto_stop:g} s'

    def write_speeds(self, left: int, right: int) -> None:
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
        self._line.drain()

    def _transact(self, request: bytes) -> bytes:
        if not self._has_checksum:
            return self._exchange(request)
        reply = self._exchange(with_checksum(request[:-1]) + END_OF_COMMAND)
        text = without_checksum(reply.removesuffix(b'\r\n'))
        if text is None:
            raise _bad_reply(reply, 'a line with a valid checksum')
        return text + b'\r\n'

    def _exchange(self, request: bytes) -> bytes:
        self._line.discard_received()
        self._line.write(request)
        reply = self._line.read_line(REPLY_MAX)
        if not reply.endswith(b'\n') and len(reply) < REPLY_MAX:
            name = request.decode().strip()
            raise NoReplyError(f'the controller does not reply to {name!r}; check cable and power')
        return reply
