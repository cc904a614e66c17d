"""Serial connection to a lamp with `firmware/led_beacon`, whose README specifies the protocol."""

from __future__ import annotations

import os
import select
import termios
import time
from collections.abc import Iterable
from dataclasses import dataclass
from pathlib import Path
from types import TracebackType
from typing import Self

from vlc_beacon.core.vlc_beacon_error import VlcBeaconError

PROTOCOL_VERSION = 1
CHUNK_BYTES = 32
"""Frame bytes per line."""
VERSION_REQUEST, STATUS_REQUEST, HALT_REQUEST, PLAY_REQUEST = 'v', 's', 'h', 'p'
OK_REPLY = 'OK'


@dataclass(frozen=True)
class LampStatus:
    """Status of the lamp.

    Attributes:
        is_playing: whether a frame is playing; otherwise the lamp is constantly on.
        source: source of the frame: `none`, `kept` or `temporary`.
        length: length of the frame [bytes].
        crc: checksum of the frame, its last two bytes.
        is_busy: whether a frame is queued until the current packet ends; no other upload is accepted until then.
    """

    is_playing: bool
    source: str
    length: int
    crc: int
    is_busy: bool


def upload_requests(frame: bytes, *, keep: bool) -> list[str]:
    """Return the requests that upload a frame, to the EEPROM if ``keep``; wait for the reply to each."""
    starts = range(0, len(frame), CHUNK_BYTES)
    chunks = [f'd {start} {frame[start : start + CHUNK_BYTES].hex()}' for start in starts]
    return [f'b {len(frame)}', *chunks, 'k' if keep else 't']


def check_version(reply: str) -> None:
    """Check firmware and protocol version; raises `VlcBeaconError`."""
    tokens = reply.split()
    if tokens[:1] != ['led_beacon'] or tokens[1:2] != [str(PROTOCOL_VERSION)]:
        raise VlcBeaconError(
            f'the lamp replied {reply!r}, expected led_beacon {PROTOCOL_VERSION}; flash firmware/led_beacon'
        )


def read_status(reply: str) -> LampStatus:
    """Parse a status reply; raises `VlcBeaconError` if it is malformed."""
    try:
        state, source, length, crc, busy = reply.split()
        return LampStatus(state == 'playing', source, int(length), int(crc, 16), busy == '1')
    except ValueError as error:
        raise VlcBeaconError(f'the lamp replied {reply!r}, which is not a status') from error


BAUD = termios.B115200
CONNECT_TIMEOUT = 5.0
"""Connection timeout [s]; opening the port resets an Arduino, whose bootloader runs for up to two seconds."""
RETRY_INTERVAL = 0.5
REPLY_TIMEOUT = 4.0
"""Reply timeout [s]; storing the longest frame takes 1.8 s."""
POLL_INTERVAL = 0.02
LINE_MAX = 200
"""Maximum length of a reply."""


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
            check_version(self._connect())
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
        """Upload and play a frame.

        Args:
            frame: frame bytes.
            keep: whether to store the frame in the EEPROM; otherwise it is played for its number of plays.

        Raises:
            VlcBeaconError: the lamp rejects it, or does not reply.
        """
        for request in upload_requests(frame, keep=keep):
            self._command(request)

    def stream(self, frames: Iterable[bytes]) -> None:
        """Play frames in sequence, each as soon as the lamp accepts it; none of them is stored."""
        for frame in frames:
            while self.status().is_busy:
                time.sleep(POLL_INTERVAL)
            self.load(frame, keep=False)

    def status(self) -> LampStatus:
        """Return the status of the lamp."""
        return read_status(self._request(STATUS_REQUEST))

    def halt(self) -> None:
        """Stop the modulation; the lamp is constantly on."""
        self._command(HALT_REQUEST)

    def play(self) -> None:
        """Resume playing."""
        self._command(PLAY_REQUEST)

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

    def _connect(self) -> str:
        """Request the version until the lamp replies, and drop replies to earlier requests."""
        end = time.monotonic() + CONNECT_TIMEOUT
        while time.monotonic() < end:
            # The carriage return ends a line started by noise.
            self._write(f'\r{VERSION_REQUEST}\r')
            reply = self._read_line(RETRY_INTERVAL)
            if reply is not None and not reply.startswith('ERR'):
                while time.monotonic() < end and self._read_line(RETRY_INTERVAL / 5.0) is not None:
                    pass
                return reply
        raise VlcBeaconError(
            f'no lamp replies on {self._path}: check the wiring and flash firmware/led_beacon'
        )

    def _command(self, request: str) -> None:
        reply = self._request(request)
        if reply != OK_REPLY:
            raise VlcBeaconError(f'the lamp on {self._path} replied {reply!r} to {request[:12]!r}')

    def _request(self, request: str) -> str:
        self._write(request + '\r')
        reply = self._read_line(REPLY_TIMEOUT)
        if reply is None:
            raise VlcBeaconError(f'the lamp on {self._path} does not reply')
        return reply

    def _write(self, text: str) -> None:
        data = text.encode('ascii')
        while data:
            select.select([], [self._file], [], REPLY_TIMEOUT)
            try:
                data = data[os.write(self._file, data) :]
            except OSError as error:
                raise VlcBeaconError(
                    f'the lamp on {self._path} was disconnected: {error.strerror}'
                ) from error

    def _read_line(self, seconds: float) -> str | None:
        """Return the next line, None on timeout."""
        end = time.monotonic() + seconds
        while b'\n' not in self._received:
            if len(self._received) > LINE_MAX or time.monotonic() > end:
                self._received = b''
                return None
            if not select.select([self._file], [], [], max(0.0, end - time.monotonic()))[0]:
                return None
            try:
                received = os.read(self._file, 256)
            except OSError as error:
                raise VlcBeaconError(
                    f'the lamp on {self._path} was disconnected: {error.strerror}'
                ) from error
            if not received:
                raise VlcBeaconError(f'the lamp on {self._path} was disconnected')
            self._received += received
        line, self._received = self._received.split(b'\n', 1)
        return line.decode('ascii', 'replace').strip()
