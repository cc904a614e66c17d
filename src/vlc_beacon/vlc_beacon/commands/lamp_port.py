"""Serial connection to a lamp with `firmware/led_beacon`, whose README specifies the protocol."""

import os
import select
import termios
import time
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from types import TracebackType
from typing import Self

from vlc_beacon.core.vlc_beacon_error import VlcBeaconError

PROTOCOL_VERSION = 1
CHUNK_BYTES = 32
"""Frame bytes per line."""
BAUD = termios.B115200
CONNECT_TIMEOUT = 5.0
"""Connection timeout [s]; opening the port resets an Arduino, whose bootloader runs for up to two seconds."""
RETRY_INTERVAL = 0.5
REPLY_TIMEOUT = 4.0
"""Reply timeout [s]; storing the longest frame takes 1.8 s."""
LINE_MAX = 200
"""Maximum length of a reply."""


def upload_requests(frame: bytes, *, keep: bool) -> list[str]:
    """Return the requests that upload a frame, to the EEPROM if ``keep``; wait for the reply to each."""
    starts = range(0, len(frame), CHUNK_BYTES)
    chunks = [f'd {start} {frame[start : start + CHUNK_BYTES].hex()}' for start in starts]
    return [f'b {len(frame)}', *chunks, 'k' if keep else 't']


class LampPort:
    """A lamp on a serial port, used as a context manager.

    Args:
        path: path of the device.

    Raises:
        VlcBeaconError: the device cannot be opened, or no lamp replies.
    """

    def __init__(self, path: Path) -> None:
        self._path = path
        self._received = b''
        try:
            self._file = os.open(path, os.O_RDWR | os.O_NOCTTY | os.O_NONBLOCK)
        except OSError as error:
            raise VlcBeaconError(f'serial port {path} cannot be opened: {error.strerror}') from error
        try:
            self._configure_port()
            self._connect()
        except BaseException:
            os.close(self._file)
            raise

    def __enter__(self) -> Self:
        """Return the port."""
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        """Close the port; the lamp continues."""
        os.close(self._file)

    def load(self, frame: bytes, *, keep: bool) -> None:
        """Upload and play a frame; raises `VlcBeaconError` if the lamp rejects it or does not reply.

        Args:
            frame: frame bytes.
            keep: whether to store the frame in the EEPROM; otherwise it is played for its number of plays.
        """
        for request in upload_requests(frame, keep=keep):
            self._write(request + '\r')
            reply = self._read_line(REPLY_TIMEOUT)
            if reply is None:
                raise VlcBeaconError(f'the lamp on {self._path} does not reply')
            if reply != 'OK':
                raise VlcBeaconError(f'the lamp on {self._path} replied {reply!r} to {request[:12]!r}')

    def _configure_port(self) -> None:
        """Set raw 8-bit mode, without a reset when the port is closed and opened again."""
        try:
            iflag, oflag, cflag, lflag, _, _, controls = termios.tcgetattr(self._file)
            iflag, oflag, lflag = 0, 0, 0
            cflag = termios.CS8 | termios.CREAD | termios.CLOCAL
            attributes = [iflag, oflag, cflag, lflag, BAUD, BAUD, controls]
            termios.tcsetattr(self._file, termios.TCSANOW, attributes)
            termios.tcflush(self._file, termios.TCIOFLUSH)
        except termios.error as error:
            raise VlcBeaconError(f'{self._path} is not a serial port: {error.args[1]}') from error

    def _connect(self) -> None:
        """Request the version until the lamp replies, drop replies to earlier requests, and check the version."""
        end = time.monotonic() + CONNECT_TIMEOUT
        while time.monotonic() < end:
            # The carriage return ends a line started by noise.
            self._write('\rv\r')
            reply = self._read_line(RETRY_INTERVAL)
            if reply is not None and not reply.startswith('ERR'):
                while time.monotonic() < end and self._read_line(RETRY_INTERVAL / 5.0) is not None:
                    pass
                if reply.split()[:2] != ['led_beacon', str(PROTOCOL_VERSION)]:
                    expected = f'expected led_beacon {PROTOCOL_VERSION}; flash firmware/led_beacon'
                    raise VlcBeaconError(f'the lamp replied {reply!r}, {expected}')
                return
        raise VlcBeaconError(f'no lamp replies on {self._path}: check the wiring and flash firmware/led_beacon')

    def _write(self, text: str) -> None:
        data = text.encode('ascii')
        while data:
            select.select([], [self._file], [], REPLY_TIMEOUT)
            with self._reporting_disconnection():
                data = data[os.write(self._file, data) :]

    def _read_line(self, seconds: float) -> str | None:
        """Return the next line, None on timeout."""
        end = time.monotonic() + seconds
        while b'\n' not in self._received:
            if len(self._received) > LINE_MAX or time.monotonic() > end:
                self._received = b''
                return None
            if not select.select([self._file], [], [], max(0.0, end - time.monotonic()))[0]:
                return None
            with self._reporting_disconnection():
                received = os.read(self._file, 256)
            if not received:
                raise VlcBeaconError(f'the lamp on {self._path} was disconnected')
            self._received += received
        line, self._received = self._received.split(b'\n', 1)
        return line.decode('ascii', 'replace').strip()

    @contextmanager
    def _reporting_disconnection(self) -> Iterator[None]:
        try:
            yield
        except OSError as error:
            raise VlcBeaconError(f'the lamp on {self._path} was disconnected: {error.strerror}') from error
