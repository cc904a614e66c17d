"""Serialization of lamp frames for the firmware."""

from __future__ import annotations

import struct

import numpy as np

from vlc_beacon.core.packet.crc import crc16
from vlc_beacon.core.transmitter.lamp_frame import MARKER_MAX, LampFrame, Section, Train
from vlc_beacon.core.transmitter.lamp_frame_error import LampFrameError

VERSION = 1
LENGTH_MAX = 508
"""Maximum frame length: two frames with sequence number and checksum fill the EEPROM of 1024 bytes."""
_HEADER = struct.Struct('<BBHHBBBBBB')
_TRAIN = struct.Struct('<IHB')
_SECTION = struct.Struct('<BBH')
_CRC_LENGTH = 2


def bytes_of_frame(frame: LampFrame) -> bytes:
    """Serialize a frame.

    Raises:
        LampFrameError: the frame is too long.
    """
    body = b''.join(_TRAIN.pack(train.step_time, train.steps, train.first_place) for train in frame.trains)
    body += b''.join(_section_bytes(section, frame.bits) for section in frame.sections)
    length = _HEADER.size + len(body) + _CRC_LENGTH
    if length > LENGTH_MAX:
        raise LampFrameError(f'the frame has {length} bytes, the limit is {LENGTH_MAX}; send fewer packets')
    wheel = sum(state << 2 * i for i, state in enumerate(frame.wheel))
    marker = (*frame.marker, *[0] * (MARKER_MAX - len(frame.marker)))
    whole = (
        _HEADER.pack(
            VERSION,
            frame.plays,
            length,
            wheel,
            len(frame.wheel),
            frame.bits,
            len(frame.trains),
            len(frame.marker),
            *marker,
        )
        + body
    )
    return whole + crc16(whole).to_bytes(_CRC_LENGTH)


def frame_of_bytes(data: bytes) -> LampFrame:
    """Parse a frame.

    Raises:
        LampFrameError: the firmware would reject the bytes.
    """
    if not _HEADER.size + _CRC_LENGTH <= len(data) <= LENGTH_MAX or crc16(data):
        raise LampFrameError('invalid lamp frame: wrong length or checksum')
    version, plays, length, wheel, wheel_length, bits, trains, marker_length, *marker = _HEADER.unpack_from(
        data
    )
    if version != VERSION:
        raise LampFrameError(f'lamp frame version {version} is not supported, expected {VERSION}')
    begin, end = _HEADER.size + trains * _TRAIN.size, length - _CRC_LENGTH
    if length != len(data) or begin > end:
        raise LampFrameError(
            f'the lamp frame header with {length} bytes and {trains} symbols does not match the data'
        )
    if marker_length > MARKER_MAX:
        raise LampFrameError(
            f'the preamble of the lamp frame has {marker_length} symbols, the limit is {MARKER_MAX}'
        )
    rows = _TRAIN.iter_unpack(data[_HEADER.size : begin])
    return LampFrame(
        tuple(wheel >> 2 * i & 3 for i in range(wheel_length)),
        bits,
        tuple(Train(first, steps, step_time) for step_time, steps, first in rows),
        tuple(marker[:marker_length]),
        _sections_of(data[begin:end], bits),
        plays,
    )


def _section_bytes(section: Section, bits: int) -> bytes:
    symbols = section.symbols.reshape(-1, 1) >> np.arange(bits)[::-1] & 1
    head = _SECTION.pack(section.symbols.shape[0], section.repeats, section.symbols.shape[1])
    return head + np.packbits(symbols.ravel().astype(np.uint8)).tobytes()


def _sections_of(data: bytes, bits: int) -> list[Section]:
    sections = []
    while data:
        if len(data) < _SECTION.size:
            raise LampFrameError('the lamp frame is truncated within a packet')
        groups, repeats, count = _SECTION.unpack_from(data)
        total = groups * count * bits
        end = _SECTION.size + (total + 7) // 8
        if len(data) < end:
            raise LampFrameError('the lamp frame is truncated within a packet')
        ones = np.unpackbits(np.frombuffer(data[_SECTION.size : end], np.uint8))[:total]
        symbols = ones.reshape(groups, count, bits) @ (1 << np.arange(bits)[::-1])
        sections.append(Section(symbols.astype(np.int64), repeats))
        data = data[end:]
    return sections
