"""ROSArduinoBridge's protocol: a letter and its arguments, ended by a carriage return; one reply to each.

A line feed would become the letter of the next command, so none is ever sent. The protocol has no checksum: a reply is
taken only if it has exactly the form that it must have.
"""

from __future__ import annotations

import re
from dataclasses import dataclass

from motor_bridge.core.motor_bridge_error import MotorBridgeError
from motor_bridge.core.wheel_base import TICKS_MAX

END_OF_COMMAND = b'\r'
"""Sent alone it ends what noise or a killed program began."""
READ_ENCODERS = b'e\r'
ASK_BAUD = b'b\r'
STOP = b'm 0 0\r'
REPLY_MAX = 64
"""Bytes; whoever sends more without an end is no motor controller."""
_COUNTS = re.compile(rb'(-?\d{1,10}) (-?\d{1,10})\r\n')
_COUNT_MIN, _COUNT_MAX = -(2**31), 2**31 - 1
_SHOWN_MAX = 40


class LinkError(MotorBridgeError):
    """The controller does not answer as it must."""


class NoReplyError(LinkError):
    """No whole reply came in time."""


class BadReplyError(LinkError):
    """A reply has another form than it must have."""


@dataclass(frozen=True)
class WheelCounts:
    """Counts of both encoders, in 32 bits.

    Attributes:
        left: ticks.
        right: ticks.
    """

    left: int
    right: int


def speeds_request(left: int, right: int) -> bytes:
    """Return the command that sets both wheels' speeds [ticks a frame].

    Raises:
        MotorBridgeError: a number that does not fit into 16 bits, of which the controller would make full reverse.
    """
    if max(abs(left), abs(right)) > TICKS_MAX:
        raise MotorBridgeError(f'{left} and {right} ticks a frame are too many; at most {TICKS_MAX}')
    return f'm {left} {right}\r'.encode()


def gains_request(proportional: int, derivative: int, integral: int, divisor: int) -> bytes:
    """Return the command that sets the gains of the speed control."""
    return f'u {proportional}:{derivative}:{integral}:{divisor}\r'.encode()


def check_done(reply: bytes) -> None:
    """Check the reply to a command that asks for nothing.

    Raises:
        BadReplyError: it is not ``OK``.
    """
    if reply != b'OK\r\n':
        raise _bad(reply, 'OK')


def read_baud(reply: bytes) -> int:
    """Return the baud rate in the reply to ``b``.

    Raises:
        BadReplyError: it is no number.
    """
    if not re.fullmatch(rb'\d{3,7}\r\n', reply):
        raise _bad(reply, 'a baud rate')
    return int(reply)


def read_counts(reply: bytes) -> WheelCounts:
    r"""Return the counts in the reply to ``e``, which is ``^-?\d+ -?\d+\r\n$``.

    Raises:
        BadReplyError: it has another form, or a count that 32 bits do not hold.
    """
    match = _COUNTS.fullmatch(reply)
    if match is None:
        raise _bad(reply, 'two counts')
    counts = WheelCounts(int(match[1]), int(match[2]))
    if not all(_COUNT_MIN <= count <= _COUNT_MAX for count in (counts.left, counts.right)):
        raise _bad(reply, 'two counts of 32 bits')
    return counts


def _bad(reply: bytes, wanted: str) -> BadReplyError:
    shown = reply[:_SHOWN_MAX].decode('ascii', 'backslashreplace').encode('unicode_escape').decode()
    remedy = 'check wiring and noise'
    if reply == b'Invalid Command\r\n':
        remedy += ', and whether its firmware takes speeds of so many ticks a frame'
    return BadReplyError(f"the controller answers '{shown}' instead of {wanted}; {remedy}")
