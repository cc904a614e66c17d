"""The serial line to a lamp that runs `firmware/led_beacon`."""

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
"""Opening the line resets an Arduino, whose bootloader then listens for up to two seconds."""
WAKE_EVERY = 0.5
ANSWER_SECONDS = 4.0
"""Keeping the longest frame takes 1.8 s."""
ASK_EVERY = 0.02
LINE_MAX = 200
"""No answer is longer; who sends more without an end is no lamp."""


class LampPort:
    """A lamp on a serial line, to be used in a `with` statement.

    Args:
        path: of the device.

    Raises:
        VlcBeaconError: the device cannot be opened, or no lamp answers.
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
        """Close the port; the lamp goes on."""
        os.close(self._file)

    def load(self, frame: bytes, *, keep: bool) -> None:
        """Let the lamp play a frame.

        Args:
            frame: its bytes.
            keep: over power off; or only until the frame has been played as often as it says.

        Raises:
            VlcBeaconError: the lamp refuses it, or does not answer.
        """
        for request in upload_requests(frame, keep=keep):
            self._do(request)

    def stream(self, frames: Iterable[bytes]) -> None:
        """Play frames one after the other, each as soon as the lamp takes it; none of them is kept."""
        for frame in frames:
            while self.status().is_busy:
                time.sleep(ASK_EVERY)
            self.load(frame, keep=False)

    def status(self) -> LampStatus:
        """Return what the lamp does."""
        return read_status(self._ask(STATUS_REQUEST))

    def shine_steadily(self) -> None:
        """Stop playing."""
        self._do(STEADY_REQUEST)

    def play(self) -> None:
        """Play again."""
        self._do(PLAY_REQUEST)

    def _set_line(self) -> None:
        """Eight bits as they are, and no reset when the port is closed and opened again."""
        try:
            iflag, oflag, cflag, lflag, _, _, controls = termios.tcgetattr(self._file)
            iflag, oflag, lflag = 0, 0, 0
            cflag = termios.CS8 | termios.CREAD | termios.CLOCAL
            attributes = [iflag, oflag, cflag, lflag, BAUD, BAUD, controls]
            termios.tcsetattr(self._file, termios.TCSANOW, attributes)
            termios.tcflush(self._file, termios.TCIOFLUSH)
        except termios.error as error:
            raise VlcBeaconError(f'{self._path} is no serial port: {error.args[1]}') from error

    def _wake(self) -> str:
        """Ask who is there until somebody answers, and drop the answers of the asking before."""
        end = time.monotonic() + WAKE_SECONDS
        while time.monotonic() < end:
            # The carriage return ends what noise may have begun.
            self._write(f'\r{VERSION_REQUEST}\r')
            answer = self._read_line(WAKE_EVERY)
            if answer is not None and not answer.startswith('ERR'):
                while time.monotonic() < end and self._read_line(WAKE_EVERY / 5.0) is not None:
                    pass
                return answer
        raise VlcBeaconError(
            f'no lamp answers on {self._path}: check the wiring and flash firmware/led_beacon'
        )

    def _do(self, request: str) -> None:
        answer = self._ask(request)
        if answer != DONE:
            raise VlcBeaconError(f'the lamp on {self._path} answers {answer!r} to {request[:12]!r}')

    def _ask(self, request: str) -> str:
        self._write(request + '\r')
        answer = self._read_line(ANSWER_SECONDS)
        if answer is None:
            raise VlcBeaconError(f'the lamp on {self._path} does not answer')
        return answer

    def _write(self, text: str) -> None:
        data = text.encode('ascii')
        while data:
            select.select([], [self._file], [], ANSWER_SECONDS)
            try:
                data = data[os.write(self._file, data) :]
            except OSError as error:
                raise VlcBeaconError(f'the lamp on {self._path} is gone: {error.strerror}') from error

    def _read_line(self, seconds: float) -> str | None:
        """Return the next line, None where none comes in time."""
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
                raise VlcBeaconError(f'the lamp on {self._path} is gone: {error.strerror}') from error
            if not received:
                raise VlcBeaconError(f'the lamp on {self._path} is gone')
            self._received += received
        line, self._received = self._received.split(b'\n', 1)
        return line.decode('ascii', 'replace').strip()
