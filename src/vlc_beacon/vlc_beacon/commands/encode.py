"""``encode``: encode an ID, data or signed commands as a lamp waveform and as a frame for the lamp firmware."""

import argparse
import math
import os
import select
import sys
import termios
import time
from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from pathlib import Path
from typing import Self

from shirube_core.command import add_settings, run_command, settings_from
from shirube_core.files import atomic_write, write_text
from shirube_core.settings import SettingsError
from shirube_core.waveform import waveform_to_csv
from vlc_beacon.core.light_code.code_profile import CodeProfile
from vlc_beacon.core.transmitter.lamp_frame import frame_to_bytes
from vlc_beacon.core.transmitter.lamp_program import TONE_NAME, EncodingSettings, LampProgram, encode_packets
from vlc_beacon.core.transmitter.message_encoder import OPERATIONS, EncoderContext, encode_messages
from vlc_beacon.core.vlc_beacon_error import VlcBeaconError
from vlc_beacon.files.authorization_files import read_key

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
        return self

    def __exit__(self, *_: object) -> None:
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


def main(arguments: Sequence[str] | None = None) -> int:
    """Run the command; return 0, or 1 when an option or a file is invalid or the lamp does not reply."""
    options = make_parser().parse_args(arguments)
    return run_command('encode', lambda: encode(options), (VlcBeaconError, SettingsError))


def encode(options: argparse.Namespace) -> None:
    """Encode, print the requirements of the receiver, and write or send the requested outputs."""
    settings = settings_from(options, EncodingSettings)
    key = read_key(options.key_file) if options.key_file is not None else None
    # Counters from the clock need not be stored; see `files.counter_file`.
    counter = int(time.time()) if options.counter is None else options.counter
    if settings.code == TONE_NAME and options.messages != ['id']:
        raise VlcBeaconError(f'a tone carries the identity of the lamp only; leave out {" ".join(options.messages)}')
    context = EncoderContext(options.beacon, key, counter, options.one_shot)
    packets = encode_messages(options.messages, context)
    program = encode_packets(packets, settings)
    print(_summary(program.profile, len(packets), program.waveform.period))
    if any(message.partition(':')[0] in OPERATIONS for message in options.messages):
        print(f'{"counter":<16}{counter}')
    if options.csv is not None:
        write_text(options.csv, waveform_to_csv(program.waveform))
    if options.frame is not None or options.port is not None:
        _write_frame(program, options)


def _write_frame(program: LampProgram, options: argparse.Namespace) -> None:
    """Write the frame to a file and send it to a lamp, as requested."""
    frame = frame_to_bytes(program.frame)
    print(f'{"frame":<16}{len(frame)} bytes')
    if options.frame is not None:
        with atomic_write(options.frame) as file:
            file.write(frame)
    if options.port is not None:
        with LampPort(options.port) as port:
            port.load(frame, keep=options.keep)
        print(f'{options.port}: playing' + (', stored in the EEPROM' if options.keep else ''))


def _summary(profile: CodeProfile, packets: int, period: float) -> str:
    is_tone = math.isinf(profile.command_seconds)
    plural = 's' if packets > 1 else ''
    rows = (
        ('code', profile.name),
        ('lamp', f'must cover at least {profile.rows_min} image rows'),
        ('period', f'{1e3 * period:.4g} ms' if is_tone else f'{period:.2f} s for {packets} packet{plural}'),
        ('ID duration', f'{profile.id_seconds:.2f} s'),
    )
    command = '' if is_tone else f', command {profile.command_seconds:.2f} s'
    return '\n'.join(f'{name:<16}{text}' for name, text in rows) + command


def make_parser() -> argparse.ArgumentParser:
    """Return the command-line parser."""
    parser = argparse.ArgumentParser(
        prog='encode', description='Encode an ID, data or signed commands as the waveform of a lamp.'
    )
    add = parser.add_argument
    add('beacon', type=int, help='ID of the lamp')
    add('messages', nargs='*', default=['id'], metavar='MESSAGE',
        help='messages sent in turn (default: id): id, text:..., hex:..., stop, resume, slow:M_S, speed_up:M_S, '
        'turn:RAD (counterclockwise)')  # fmt: skip
    add('--csv', type=Path, metavar='FILE', help='write the waveform to this file: t [s], levels 0..1, one period')
    add('--frame', type=Path, metavar='FILE', help='write the frame for firmware/led_beacon to this file')
    add('--port', type=Path, metavar='DEVICE', help='send the frame to the lamp on this serial port')
    add('--keep', action='store_true', help='store the frame in the EEPROM of the lamp')
    add('--key-file', type=Path, metavar='FILE', help='key that signs commands; created by make_key')
    add('--counter', type=int, help='counter of the commands (default: seconds since 1970)')
    add('--one-shot', action='store_true', help='the command is executed once and is not a zone rule')
    add_settings(parser, EncodingSettings)
    return parser


if __name__ == '__main__':
    sys.exit(main())
