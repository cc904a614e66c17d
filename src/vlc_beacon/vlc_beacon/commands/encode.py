"""``encode``: encode an ID, data or signed commands as a lamp waveform and as a frame for the lamp firmware."""

import argparse
import math
import sys
import time
from collections.abc import Sequence
from pathlib import Path

from shirube_core.command import add_settings, run_command, settings_from
from shirube_core.files import atomic_write, write_text
from shirube_core.settings import SettingsError
from shirube_core.waveform import waveform_to_csv
from vlc_beacon.commands.lamp_port import LampPort
from vlc_beacon.core.light_code.code_profile import CodeProfile
from vlc_beacon.core.transmitter.lamp_frame import frame_to_bytes
from vlc_beacon.core.transmitter.lamp_program import TONE_NAME, EncodingSettings, LampProgram, encode_packets
from vlc_beacon.core.transmitter.message_encoder import OPERATIONS, EncoderContext, encode_messages
from vlc_beacon.core.vlc_beacon_error import VlcBeaconError
from vlc_beacon.files.authorization_files import read_key


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
