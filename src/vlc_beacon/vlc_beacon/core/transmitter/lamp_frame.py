"""Frame of the lamp firmware: an output pattern, symbols as pulse trains through it, and the packets.

One format holds all light codes: UFSOOK symbols, tones and Manchester bits are all sequences of steps through a cyclic
pattern of output states. `firmware/led_beacon/README.md` specifies the format.
"""

import struct
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from vlc_beacon.core.packet.data_packet import crc16
from vlc_beacon.core.vlc_beacon_error import LampFrameError

TICK_RATE = 16e6
"""Nominal clock of the lamp's timer [1/s]."""
STEP_FRACTION = 1 << 16
"""Fractions per tick of the step time."""
STEP_TICKS_MIN, STEP_TICKS_MAX = 1000, 65000
"""Limits of the step duration: the firmware must prepare the next step, and the timer has 16 bits."""
PATTERN_MAX, BITS_MAX, PULSETRAINS_MAX, PREAMBLE_MAX = 8, 3, 12, 2
PLAYS_MAX = 255


@dataclass(frozen=True)
class PulseTrain:
    """A symbol: steps through the pattern.

    Attributes:
        first_index: index of the first state in the pattern.
        steps: number of steps, 1 to 65535.
        step_time: duration of a step [ticks / `STEP_FRACTION`].
    """

    first_index: int
    steps: int
    step_time: int

    def __post_init__(self) -> None:
        ticks = self.step_time / STEP_FRACTION
        if not STEP_TICKS_MIN <= ticks < STEP_TICKS_MAX + 1:
            raise LampFrameError(
                f'a step lasts {ticks:.0f} ticks, the firmware supports {STEP_TICKS_MIN} to {STEP_TICKS_MAX}'
            )
        if not 1 <= self.steps <= 0xFFFF:
            raise LampFrameError(f'a symbol has {self.steps} steps, it must have from 1 to 65535')


def pulse_train_of_duration(first_index: int, steps: int, duration: float, tick_rate: float) -> PulseTrain:
    """Return the pulse train of steps with a total duration [s]."""
    return PulseTrain(first_index, steps, round(duration * tick_rate * STEP_FRACTION / steps))


@dataclass(frozen=True)
class Section:
    """A packet: bursts of data symbols, each preceded by the preamble.

    Attributes:
        symbols: data symbols, shape (bursts, n).
        repeats: number of transmissions of each burst.
    """

    symbols: NDArray[np.int64]
    repeats: int = 1

    def __post_init__(self) -> None:
        bursts, count = self.symbols.shape
        if not 1 <= bursts <= 0xFF or not 1 <= count <= 0xFFFF:
            raise LampFrameError(f'a packet has {bursts} bursts of {count} symbols, the limit is 255 of 65535')
        if not 1 <= self.repeats <= 0xFF:
            raise LampFrameError(f'a burst is repeated {self.repeats} times, it must be from 1 to 255')


@dataclass(frozen=True)
class LampFrame:
    """The periodic output of the lamp.

    Attributes:
        pattern: cyclic output states, 1 to 8; bit 0 is half A, bit 1 half B.
        bits: bits per data symbol, 1 to 3.
        pulse_trains: symbol waveforms, data symbols first.
        preamble: symbols of the preamble of each burst, up to 2.
        sections: packets.
        plays: repetitions of a temporary frame before the stored frame resumes; 0 for no limit.
    """

    pattern: tuple[int, ...]
    bits: int
    pulse_trains: tuple[PulseTrain, ...]
    preamble: tuple[int, ...]
    sections: Sequence[Section]
    plays: int = 0

    def __post_init__(self) -> None:
        if not 1 <= len(self.pattern) <= PATTERN_MAX or not all(0 <= state <= 3 for state in self.pattern):
            raise LampFrameError(f'the pattern is {self.pattern}, it must have 1 to {PATTERN_MAX} states from 0 to 3')
        if not 1 <= self.bits <= BITS_MAX or not 1 << self.bits <= len(self.pulse_trains) <= PULSETRAINS_MAX:
            raise LampFrameError(f'{len(self.pulse_trains)} symbols are invalid for data symbols of {self.bits} bits')
        if len(self.preamble) > PREAMBLE_MAX or not all(0 <= s < len(self.pulse_trains) for s in self.preamble):
            raise LampFrameError(f'the preamble is {self.preamble}, it must be up to {PREAMBLE_MAX} of the symbols')
        if not all(train.first_index < len(self.pattern) for train in self.pulse_trains):
            raise LampFrameError('a symbol starts beyond the end of the pattern')
        if not 0 <= self.plays <= PLAYS_MAX:
            raise LampFrameError(f'plays is {self.plays}, it must be from 0 to {PLAYS_MAX}')
        if not self.sections:
            raise LampFrameError('a frame must have at least one packet')


VERSION = 1
LENGTH_MAX = 508
"""Maximum frame length: two frames with sequence number and checksum fill the EEPROM of 1024 bytes."""
HEADER = struct.Struct('<BBHHBBBBBB')
TRAIN = struct.Struct('<IHB')
SECTION = struct.Struct('<BBH')
_CRC_LENGTH = 2


def frame_to_bytes(frame: LampFrame) -> bytes:
    """Serialize a frame; raises `LampFrameError` if it is too long."""
    body = b''.join(TRAIN.pack(train.step_time, train.steps, train.first_index) for train in frame.pulse_trains)
    body += b''.join(_section_to_bytes(section, frame.bits) for section in frame.sections)
    length = HEADER.size + len(body) + _CRC_LENGTH
    if length > LENGTH_MAX:
        raise LampFrameError(f'the frame has {length} bytes, the limit is {LENGTH_MAX}; send fewer packets')
    pattern = sum(state << 2 * i for i, state in enumerate(frame.pattern))
    preamble = (*frame.preamble, *[0] * (PREAMBLE_MAX - len(frame.preamble)))
    counts = len(frame.pattern), frame.bits, len(frame.pulse_trains), len(frame.preamble)
    whole = HEADER.pack(VERSION, frame.plays, length, pattern, *counts, *preamble) + body
    return whole + crc16(whole).to_bytes(_CRC_LENGTH)


def _section_to_bytes(section: Section, bits: int) -> bytes:
    symbols = section.symbols.reshape(-1, 1) >> np.arange(bits)[::-1] & 1
    head = SECTION.pack(section.symbols.shape[0], section.repeats, section.symbols.shape[1])
    return head + np.packbits(symbols.ravel().astype(np.uint8)).tobytes()
