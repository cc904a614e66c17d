"""Serial connection to a lamp with `firmware/led_beacon`."""

from __future__ import annotations

import os
import select
import termios
import time
from collections.abc import Iterable
from pathlib import Path
from types import TracebackType
from typing import Self

from vlc_beacon.core.transmitter.serial_protocol import (
    DONE,
    PLAY_REQUEST,
    STATUS_REQUEST,
    STEADY_REQUEST,
    VERSION_REQUEST,
    LampStatus,
    check_version,
    read_status,
    upload_requests,
)
from vlc_beacon.core.vlc_beacon_error import VlcBeaconError

BAUD = termios.B115200
WAKE_SECONDS = 5.0
"""Connection timeout [s]; opening the port resets an Arduino, whose bootloader runs for up to two seconds."""
WAKE_EVERY = 0.5
ANSWER_SECONDS = 4.0
"""Reply timeout [s]; storing the longest frame takes 1.8 s."""
ASK_EVERY = 0.02
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
            self._set_line()
            check_version(self._wake())
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
            self._do(request)

    def stream(self, frames: Iterable[bytes]) -> None:
        """Play frames in sequence, each as soon as the lamp accepts it; none of them is stored."""
        for frame in frames:
            while self.status().is_busy:
                time.sleep(ASK_EVERY)
            self.load(frame, keep=False)

    def status(self) -> LampStatus:
        """Return the status of the lamp."""
        return read_status(self._ask(STATUS_REQUEST))

    def shine_steadily(self) -> None:
        """Stop the modulation; the lamp is constantly on."""
        self._do(STEADY_REQUEST)

    def play(self) -> None:
        """Resume playing."""
        self._do(PLAY_REQUEST)

    def _set_line(self) -> None:
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

    def _wake(self) -> str:
        """Request the version until the lamp replies, and drop replies to earlier requests."""
        end = time.monotonic() + WAKE_SECONDS
        while time.monotonic() < end:
            # The carriage return ends a line started by noise.
            self._write(f'\r{VERSION_REQUEST}\r')
            answer = self._read_line(WAKE_EVERY)
            if answer is not None and not answer.startswith('ERR'):
                while time.monotonic() < end and self._read_line(WAKE_EVERY / 5.0) is not None:
                    pass
                return answer
        raise VlcBeaconError(
            f'no lamp replies on {self._path}: check the wiring and flash firmware/led_beacon'
        )

    def _do(self, request: str) -> None:
        answer = self._ask(request)
        if answer != DONE:
            raise VlcBeaconError(f'the lamp on {self._path} replied {answer!r} to {request[:12]!r}')

    def _ask(self, request: str) -> str:
        self._write(request + '\r')
        answer = self._read_line(ANSWER_SECONDS)
        if answer is None:
            raise VlcBeaconError(f'the lamp on {self._path} does not reply')
        return answer

    def _write(self, text: str) -> None:
        data = text.encode('ascii')
        while data:
            select.select([], [self._file], [], ANSWER_SECONDS)
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
