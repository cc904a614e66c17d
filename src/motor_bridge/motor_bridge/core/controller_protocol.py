"""Interface between the bridge and the protocol of a motor controller: one file per protocol implements it."""

from dataclasses import dataclass
from typing import Protocol

from motor_bridge.core.motor_bridge_error import MotorBridgeError
from shirube_core.crc import crc8


def with_checksum(text: bytes) -> bytes:
    """Return a line without its end, followed by ``*`` and its checksum as two hexadecimal digits."""
    return text + b'*%02X' % crc8(text)


def without_checksum(line: bytes) -> bytes | None:
    """Return the text before a valid checksum, or None."""
    text = line.rpartition(b'*')[0]
    return text if line == with_checksum(text) else None


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


@dataclass(frozen=True)
class ControllerSetup:
    """Settings that are checked or sent when a controller is connected.

    Attributes:
        baud: baud rate, which the controller must confirm.
        gains: proportional, derivative and integral gain and divisor of the speed control.
        auto_stop: auto-stop of a controller that lets it be set [s].
    """

    baud: int
    gains: tuple[int, int, int, int]
    auto_stop: float = 2.0


class SerialLine(Protocol):
    """A serial line.

    Attributes:
        slowest_reply: longest time of a reply since `set_latency` [s].
    """

    slowest_reply: float

    def write(self, data: bytes) -> None:
        """Send bytes."""

    def read_line(self, size_max: int) -> bytes:
        """Return bytes up to a line feed, at most ``size_max``, or fewer after the reply timeout."""

    def drain(self) -> int:
        """Discard received bytes until the line is quiet; return their number."""

    def discard_received(self) -> int:
        """Discard received bytes without waiting; return their number."""

    def set_latency(self, latency: float) -> None:
        """Allow for replies that are late by so much [s]: the line is quiet after this time, replies take twice."""


class ControllerProtocol(Protocol):
    """A motor controller with two wheels; a call that the controller does not confirm raises a LinkError.

    Attributes:
        name: protocol and options in use, for the log.
        auto_stop: time after the last speeds at which the controller stops by itself [s]; infinite if unknown.
    """

    name: str
    auto_stop: float

    def connect(self, latency: float) -> WheelCounts:
        """Stop, check that it is the expected controller, send the setup and return the counts.

        It is repeated with a longer expected latency of the line [s] until it succeeds.
        """

    def write_speeds(self, left: int, right: int) -> None:
        """Set the wheel speeds [ticks per `pid_frame`]."""

    def read_counts(self) -> WheelCounts:
        """Read the encoder counts."""

    def resynchronize(self) -> None:
        """End partial commands and discard partial replies after an invalid reply."""

    def stop_and_resynchronize(self) -> None:
        """Stop the motors, whatever was received before."""
