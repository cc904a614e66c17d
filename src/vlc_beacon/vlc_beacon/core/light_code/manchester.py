"""Manchester chips in repeated slots, for rolling shutters and lamps that cover many rows.

A packet becomes a Reed-Solomon block, the block becomes numbered slots. A slot is

    preamble 111000 | number 7 bits | bytes of the block | CRC-4

in chips, a bit 1 as 10 and a bit 0 as 01; three equal chips in a row are in the preamble only. A slot is repeated until
the slowest camera has seen it whole: any rows that show as many chips as a slot has hold all of it, at worst the
end first and the beginning after it. So nothing has to be known about where a frame falls, and what frames miss,
because they were dropped or fell on the change from slot to slot, are erasures of the block.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from functools import lru_cache

import numpy as np
from numpy.typing import NDArray

from light_waveform import Waveform, waveform_of_steps
from vlc_beacon.core.vlc_beacon_error import VlcBeaconError

PREAMBLE = (1, 1, 1, 0, 0, 0)
INDEX_BITS = 7
CHECK_BITS = 4
CHECK_POLYNOMIAL = 0b10011
"""x^4 + x + 1, as in CRC-4/INTERLAKEN but begun with zeros."""
CHIP_TIMES = (1.0 / 8000.0, 1.0 / 6000.0)
"""Shortest and longest chip [s]: what rolling shutters resolve, and what leaves the eye no trace of the slots."""
SLOT_BYTES_MAX = 8
"""Of the shortest chips; see `REPETITION_MAX`."""
REPETITION_MAX = 0.02
"""A slot lasts no longer, so that its repetitions are too fast for the eye [s]."""


@dataclass(frozen=True)
class SlotFormat:
    """How a block is cut into slots.

    Attributes:
        slot_bytes: bytes of the block in a slot: more of them need more rows and waste less.
        chip_time: of a chip [s], within `CHIP_TIMES`.
        frame_rate: of the slowest camera that shall read it [1/s].
    """

    slot_bytes: int = 1
    chip_time: float = 1.0 / 8000.0
    frame_rate: float = 30.0

    def __post_init__(self) -> None:
        if not CHIP_TIMES[0] <= self.chip_time <= CHIP_TIMES[1]:
            low, high = CHIP_TIMES
            raise VlcBeaconError(f'chip_time is {self.chip_time:g} s, it must be from {low:g} to {high:g} s')
        if self.slot_bytes < 1 or self.chips * self.chip_time > REPETITION_MAX:
            chips = int(REPETITION_MAX / self.chip_time + 1e-6)
            most = ((chips - len(PREAMBLE)) // 2 - INDEX_BITS - CHECK_BITS) // 8
            raise VlcBeaconError(
                f'slot_bytes is {self.slot_bytes}, it must be from 1 to {most}, or the lamp would blink visibly'
            )

    @property
    def bits(self) -> int:
        """Bits of a slot after its preamble."""
        return INDEX_BITS + 8 * self.slot_bytes + CHECK_BITS

    @property
    def chips(self) -> int:
        """Chips of a slot."""
        return len(PREAMBLE) + 2 * self.bits

    @property
    def repeats(self) -> int:
        """How often a slot is played before the next one."""
        return 1 + math.ceil((1.0 / self.frame_rate / self.chip_time + 2.0) / self.chips)

    @property
    def slot_seconds(self) -> float:
        """How long a slot is played with its repetitions [s]."""
        return self.repeats * self.chips * self.chip_time

    def rows_min(self, row_time: float, exposure: float) -> int:
        """Return how many rows a lamp must cover to be read, for a camera's row time and exposure [s]."""
        return math.ceil(((self.chips + 1) * self.chip_time + exposure) / row_time)


@dataclass(frozen=True)
class Slot:
    """A part of a block.

    Attributes:
        index: its number, 0 to 127.
        content: its bytes.
    """

    index: int
    content: bytes

    def chips(self) -> NDArray[np.uint8]:
        """Return the chips, shape (n,), 0 and 1."""
        bits = np.concatenate([_bits_of(self.index, INDEX_BITS), _bytes_bits(self.content)])
        bits = np.append(bits, _bits_of(_check_of(bits), CHECK_BITS))
        return np.append(np.array(PREAMBLE, np.uint8), np.column_stack([bits, 1 - bits]).ravel())


def slot_of_bits(bits: NDArray[np.uint8]) -> Slot | None:
    """Return the slot of the bits after a preamble, shape (bits,), or None where its check is wrong."""
    if (bits @ _check_columns(len(bits)) % 2).any():
        return None
    content = np.packbits(bits[INDEX_BITS:-CHECK_BITS]).tobytes()
    return Slot(_number_of(bits[:INDEX_BITS]), content)


def slots_waveform(slots: list[Slot], slot_format: SlotFormat, clock_scale: float = 1.0) -> Waveform:
    """Return the waveform that plays slots, each repeated, again and again, with one part.

    Args:
        slots: at least one.
        slot_format: the repetitions and the chips' time.
        clock_scale: duration over nominal duration of everything, to simulate an inexact clock.
    """
    chips = np.concatenate([np.tile(slot.chips(), slot_format.repeats) for slot in slots])
    return waveform_of_steps(np.full(len(chips), slot_format.chip_time * clock_scale), chips)


def _bits_of(number: int, count: int) -> NDArray[np.uint8]:
    return (number >> np.arange(count)[::-1] & 1).astype(np.uint8)


def _number_of(bits: NDArray[np.uint8]) -> int:
    return int(bits @ (1 << np.arange(len(bits))[::-1]))


def _bytes_bits(content: bytes) -> NDArray[np.uint8]:
    return np.unpackbits(np.frombuffer(content, np.uint8))


def _check_of(bits: NDArray[np.uint8]) -> int:
    """Return the CRC-4 of bits."""
    value = 0
    for bit in bits.tolist():
        value = value << 1 ^ (bit << CHECK_BITS)
        if value >> CHECK_BITS:
            value ^= CHECK_POLYNOMIAL
    return value


@lru_cache(maxsize=64)
def _check_columns(count: int) -> NDArray[np.int64]:
    """Return what each of the bits with their check adds to the remainder, shape (count, CHECK_BITS)."""
    units = np.eye(count - CHECK_BITS, dtype=np.uint8)
    columns = [_bits_of(_check_of(unit), CHECK_BITS) for unit in units]
    return np.vstack([*columns, np.eye(CHECK_BITS)]).astype(np.int64)
