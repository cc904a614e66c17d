"""Serialization of lamp frames for the firmware."""

from __future__ import annotations

import struct

import numpy as np

from vlc_beacon.core.packet.crc import crc16
from vlc_beacon.core.transmitter.lamp_frame import PREAMBLE_MAX, LampFrame, PulseTrain, Section
from vlc_beacon.core.transmitter.lamp_frame_error import LampFrameError

VERSION = 1
LENGTH_MAX = 508
"""Maximum frame length: two frames with sequence number and checksum fill the EEPROM of 1024 bytes."""
_HEADER = struct.Struct('<BBHHBBBBBB')
_TRAIN = struct.Struct('<IHB')
_SECTION = struct.Struct('<BBH')
_CRC_LENGTH = 2


def frame_to_bytes(frame: LampFrame) -> bytes:
    """Serialize a frame.

    Raises:
        LampFrameError: the frame is too long.
    """
    body = b''.join(
        _TRAIN.pack(train.step_time, train.steps, train.first_index) for train in frame.pulse_trains
    )
    body += b''.join(_section_to_bytes(section, frame.bits) for section in frame.sections)
    length = _HEADER.size + len(body) + _CRC_LENGTH
    if length > LENGTH_MAX:
        raise LampFrameError(f'the frame has {length} bytes, the limit is {LENGTH_MAX}; send fewer packets')
    pattern = sum(state << 2 * i for i, state in enumerate(frame.pattern))
    preamble = (*frame.preamble, *[0] * (PREAMBLE_MAX - len(frame.preamble)))
    whole = (
        _HEADER.pack(
            VERSION,
            frame.plays,
            length,
            pattern,
            len(frame.pattern),
            frame.bits,
            len(frame.pulse_trains),
            len(frame.preamble),
            *preamble,
        )
        + body
    )
    return whole + crc16(whole).to_bytes(_CRC_LENGTH)


def frame_from_bytes(data: bytes) -> LampFrame:
    """Parse a frame.

    Raises:
        LampFrameError: the firmware would reject the bytes.
    """
    if not _HEADER.size + _CRC_LENGTH <= len(data) <= LENGTH_MAX or crc16(data):
        raise LampFrameError('invalid lamp frame: wrong length or checksum')
    version, plays, length, pattern, pattern_length, bits, pulse_trains, preamble_length, *preamble = (
        _HEADER.unpack_from(data)
    )
    if version != VERSION:
        raise LampFrameError(f'lamp frame version {version} is not supported, expected {VERSION}')
    begin, end = _HEADER.size + pulse_trains * _TRAIN.size, length - _CRC_LENGTH
    if length != len(data) or begin > end:
        raise LampFrameError(
            f'the lamp frame header with {length} bytes and {pulse_trains} symbols does not match the data'
        )
    if preamble_length > PREAMBLE_MAX:
        raise LampFrameError(
            f'the preamble of the lamp frame has {preamble_length} symbols, the limit is {PREAMBLE_MAX}'
        )
    rows = _TRAIN.iter_unpack(data[_HEADER.size : begin])
    return LampFrame(
        tuple(pattern >> 2 * i & 3 for i in range(pattern_length)),
        bits,
        tuple(PulseTrain(first, steps, step_time) for step_time, steps, first in rows),
        tuple(preamble[:preamble_length]),
        _parse_sections(data[begin:end], bits),
        plays,
    )


def _section_to_bytes(section: Section, bits: int) -> bytes:
    symbols = section.symbols.reshape(-1, 1) >> np.arange(bits)[::-1] & 1
    head = _SECTION.pack(section.symbols.shape[0], section.repeats, section.symbols.shape[1])
    return head + np.packbits(symbols.ravel().astype(np.uint8)).tobytes()


def _parse_sections(data: bytes, bits: int) -> list[Section]:
    sections = []
    while data:
        if len(data) < _SECTION.size:
            raise LampFrameError('the lamp frame is truncated within a packet')
        bursts, repeats, count = _SECTION.unpack_from(data)
        total = bursts * count * bits
        end = _SECTION.size + (total + 7) // 8
        if len(data) < end:
            raise LampFrameError('the lamp frame is truncated within a packet')
        ones = np.unpackbits(np.frombuffer(data[_SECTION.size : end], np.uint8))[:total]
        symbols = ones.reshape(bursts, count, bits) @ (1 << np.arange(bits)[::-1])
        sections.append(Section(symbols.astype(np.int64), repeats))
        data = data[end:]
    return sections
