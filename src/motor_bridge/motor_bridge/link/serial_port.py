"""The serial port of the motor controller."""

import errno
import select
import termios
from collections.abc import Iterator
from contextlib import contextmanager, suppress
from time import monotonic
from typing import Self

import serial

from motor_bridge.core.motor_bridge_error import MotorBridgeError

_QUIET_TIME = 0.02  # the line is quiet after this time without bytes, if it has no latency [s]
_DRAIN_TIMEOUT = 0.3  # timeout of draining, likewise [s]
_WRITE_TIMEOUT = 0.2  # [s]
_CHUNK = 4096
_REMEDIES = {
    errno.ENOENT: 'does not exist; connect the controller or set port',
    errno.EACCES: 'has no access permission; add the user to the group dialout or install the udev rule',
    errno.EPERM: 'has no access permission; add the user to the group dialout or install the udev rule',
    errno.EAGAIN: 'is in use by another program; stop it',
    errno.EBUSY: 'is in use by another program; stop it',
}


class PortError(MotorBridgeError):
    """A port cannot be opened or was disconnected; one line with the remedy."""


class SerialPort:
    """An open serial port, a context manager; implements `SerialLine`.

    Every error of the port is a PortError; disconnection raises OSError, SerialException or termios.error internally.
    """

    def __init__(self, path: str, baud: int, reply_timeout: float) -> None:
        """Open the port exclusively; the reply timeout [s] is that of `read_line`.

        Raises:
            PortError: the device is missing, in use, not a serial port or not permitted.
        """
        self._path, self._reply_timeout_min = path, reply_timeout
        self.set_latency(_QUIET_TIME)
        self._received = b''
        try:
            self._serial = serial.Serial(path, baud, timeout=0, write_timeout=_WRITE_TIMEOUT, exclusive=True)
        except (OSError, termios.error, ValueError) as fault:
            number = getattr(fault, 'errno', None)
            why = _REMEDIES.get(number or 0, 'is not a working serial port; set port and baud')
            raise PortError(f'{path} {why}') from fault

    def __enter__(self) -> Self:
        return self

    def __exit__(self, *_: object) -> None:
        """Close the port, even if it was disconnected."""
        with suppress(OSError, termios.error):
            self._serial.close()

    def set_latency(self, latency: float) -> None:
        """Allow for replies that are late by so much [s]: the line is quiet after this time, replies take twice."""
        self._quiet_time, self.slowest_reply = latency, 0.0
        self._reply_timeout = max(self._reply_timeout_min, 2.0 * latency)

    def write(self, data: bytes) -> None:
        """Write bytes."""
        with self._port_errors():
            self._serial.write(data)

    def read_line(self, size_max: int) -> bytes:
        """Return bytes up to a line feed, at most ``size_max``, or fewer after the reply timeout."""
        start = monotonic()
        end = start + self._reply_timeout
        while b'\n' not in self._received and len(self._received) < size_max:
            remaining = end - monotonic()
            if remaining <= 0.0 or not self._wait(remaining):
                break
            self._received += self._read()
        self.slowest_reply = max(self.slowest_reply, monotonic() - start)
        size = min(self._received.find(b'\n') + 1 or size_max, size_max)
        line, self._received = self._received[:size], self._received[size:]
        return line

    def drain(self) -> int:
        """Discard received bytes until the line is quiet or a timeout; return their number."""
        end = monotonic() + max(_DRAIN_TIMEOUT, 3.0 * self._quiet_time)
        count = self.discard_received()
        while monotonic() < end and self._wait(self._quiet_time):
            count += len(self._read())
        return count

    def discard_received(self) -> int:
        """Discard received bytes without waiting; return their number."""
        count, self._received = len(self._received), b''
        while self._wait(0.0) and count < _CHUNK:
            count += len(self._read())
        return count

    def _wait(self, seconds: float) -> bool:
        with self._port_errors():
            return bool(select.select([self._serial.fileno()], [], [], seconds)[0])

    def _read(self) -> bytes:
        with self._port_errors():
            return self._serial.read(min(_CHUNK, max(1, self._serial.in_waiting)))

    @contextmanager
    def _port_errors(self) -> Iterator[None]:
        try:
            yield
        except (OSError, termios.error, TypeError, ValueError) as fault:  # the last two: of a closed port
            raise PortError(f'{self._path} was disconnected or accepts no bytes; reconnect the controller') from fault
