"""Frame of the lamp firmware: an output pattern, symbols as pulse trains through it, and the packets.

One format holds all light codes: UFSOOK symbols, tones and Manchester bits are all sequences of steps through a cyclic
pattern of output states. `firmware/led_beacon/README.md` specifies the format.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from vlc_beacon.core.transmitter.lamp_frame_error import LampFrameError

TICK_RATE = 16e6
"""Nominal clock of the lamp's timer [1/s]."""
STEP_FRACTION = 1 << 16
"""Fractions per tick of the step time."""
STEP_TICKS_MIN, STEP_TICKS_MAX = 1000, 65000
"""Limits of the step duration: the firmware must prepare the next step, and the timer has 16 bits."""
WHEEL_MAX, BITS_MAX, TRAINS_MAX, MARKER_MAX = 8, 3, 12, 2
PLAYS_MAX = 255


@dataclass(frozen=True)
class Train:
    """A symbol: steps through the pattern.

    Attributes:
        first_place: index of the first state in the pattern.
        steps: number of steps, 1 to 65535.
        step_time: duration of a step [ticks / `STEP_FRACTION`].
    """

    first_place: int
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


def train_of_duration(first_place: int, steps: int, duration: float, tick_rate: float) -> Train:
    """Return the pulse train of steps with a total duration [s]."""
    return Train(first_place, steps, round(duration * tick_rate * STEP_FRACTION / steps))


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
        groups, count = self.symbols.shape
        if not 1 <= groups <= 0xFF or not 1 <= count <= 0xFFFF:
            raise LampFrameError(
                f'a packet has {groups} bursts of {count} symbols, the limit is 255 of 65535'
            )
        if not 1 <= self.repeats <= 0xFF:
            raise LampFrameError(f'a burst is repeated {self.repeats} times, it must be from 1 to 255')


@dataclass(frozen=True)
class LampFrame:
    """The periodic output of the lamp.

    Attributes:
        wheel: cyclic output states, 1 to 8; bit 0 is half A, bit 1 half B.
        bits: bits per data symbol, 1 to 3.
        trains: symbol waveforms, data symbols first.
        marker: symbols of the preamble of each burst, up to 2.
        sections: packets.
        plays: repetitions of a temporary frame before the stored frame resumes; 0 for no limit.
    """

    wheel: tuple[int, ...]
    bits: int
    trains: tuple[Train, ...]
    marker: tuple[int, ...]
    sections: Sequence[Section]
    plays: int = 0

    def __post_init__(self) -> None:
        if not 1 <= len(self.wheel) <= WHEEL_MAX or not all(0 <= state <= 3 for state in self.wheel):
            raise LampFrameError(
                f'the pattern is {self.wheel}, it must have 1 to {WHEEL_MAX} states from 0 to 3'
            )
        if not 1 <= self.bits <= BITS_MAX or not 1 << self.bits <= len(self.trains) <= TRAINS_MAX:
            raise LampFrameError(
                f'{len(self.trains)} symbols are invalid for data symbols of {self.bits} bits'
            )
        if len(self.marker) > MARKER_MAX or not all(0 <= s < len(self.trains) for s in self.marker):
            raise LampFrameError(
                f'the preamble is {self.marker}, it must be up to {MARKER_MAX} of the symbols'
            )
        if not all(train.first_place < len(self.wheel) for train in self.trains):
            raise LampFrameError('a symbol starts beyond the end of the pattern')
        if not 0 <= self.plays <= PLAYS_MAX:
            raise LampFrameError(f'plays is {self.plays}, it must be from 0 to {PLAYS_MAX}')
        if not self.sections:
            raise LampFrameError('a frame must have at least one packet')
