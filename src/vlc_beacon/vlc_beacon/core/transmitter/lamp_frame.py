"""What the lamp firmware plays: a wheel of states, symbols that are trains of steps along it, and the packets.

One form holds all light codes: a blink, a tone and a Manchester bit all are a few steps along a fixed cycle of the
lamp's states. `firmware/led_beacon/README.md` describes the same for the builder of the lamp.
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
"""A step's time is given in ticks over this."""
STEP_TICKS_MIN, STEP_TICKS_MAX = 1000, 65000
"""A shorter step would end before the firmware has prepared the next; a longer one does not fit its timer."""
WHEEL_MAX, BITS_MAX, TRAINS_MAX, MARKER_MAX = 8, 3, 12, 2
PLAYS_MAX = 255


@dataclass(frozen=True)
class Train:
    """A symbol: steps along the wheel.

    Attributes:
        first_place: on the wheel.
        steps: how many, 1 to 65535.
        step_time: of each [1 / `STEP_FRACTION` ticks].
    """

    first_place: int
    steps: int
    step_time: int

    def __post_init__(self) -> None:
        ticks = self.step_time / STEP_FRACTION
        if not STEP_TICKS_MIN <= ticks < STEP_TICKS_MAX + 1:
            raise LampFrameError(
                f'a step lasts {ticks:.0f} ticks, the lamp plays {STEP_TICKS_MIN} to {STEP_TICKS_MAX}'
            )
        if not 1 <= self.steps <= 0xFFFF:
            raise LampFrameError(f'a symbol has {self.steps} steps, it must have from 1 to 65535')


def train_of_duration(first_place: int, steps: int, duration: float, tick_rate: float) -> Train:
    """Return the train of steps that last so long together [s]."""
    return Train(first_place, steps, round(duration * tick_rate * STEP_FRACTION / steps))


@dataclass(frozen=True)
class Section:
    """A packet: groups of data symbols, each with the marker before it.

    Attributes:
        symbols: shape (groups, n).
        repeats: how often each group is played before the next one.
    """

    symbols: NDArray[np.int64]
    repeats: int = 1

    def __post_init__(self) -> None:
        groups, count = self.symbols.shape
        if not 1 <= groups <= 0xFF or not 1 <= count <= 0xFFFF:
            raise LampFrameError(
                f'a packet has {groups} groups of {count} symbols, up to 255 of 65535 are played'
            )
        if not 1 <= self.repeats <= 0xFF:
            raise LampFrameError(f'a group is to be played {self.repeats} times, it must be from 1 to 255')


@dataclass(frozen=True)
class LampFrame:
    """All that the lamp plays, again and again.

    Attributes:
        wheel: states of the lamp, 1 to 8; bit 0 is half A, bit 1 half B.
        bits: of a data symbol, 1 to 3.
        trains: the symbols, data symbols first.
        marker: symbols that begin each group, up to 2.
        sections: the packets.
        plays: after how many plays a temporary frame gives way to the one that is kept; 0 for never.
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
                f'the wheel is {self.wheel}, it must have 1 to {WHEEL_MAX} states from 0 to 3'
            )
        if not 1 <= self.bits <= BITS_MAX or not 1 << self.bits <= len(self.trains) <= TRAINS_MAX:
            raise LampFrameError(
                f'{len(self.trains)} symbols do not go with data symbols of {self.bits} bits'
            )
        if len(self.marker) > MARKER_MAX or not all(0 <= s < len(self.trains) for s in self.marker):
            raise LampFrameError(f'the marker is {self.marker}, it must be up to {MARKER_MAX} of the symbols')
        if not all(train.first_place < len(self.wheel) for train in self.trains):
            raise LampFrameError('a symbol begins behind the end of the wheel')
        if not 0 <= self.plays <= PLAYS_MAX:
            raise LampFrameError(f'plays is {self.plays}, it must be from 0 to {PLAYS_MAX}')
        if not self.sections:
            raise LampFrameError('a frame without packets cannot be played')
