"""Waveform of a lamp frame, with the tick resolution of the firmware."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from light_waveform import Waveform
from vlc_beacon.core.transmitter.lamp_frame import STEP_FRACTION, TICK_RATE, LampFrame, Section, Train


def waveform_of_frame(frame: LampFrame, tick_rate: float = TICK_RATE) -> Waveform:
    """Return the waveform of a frame, with two parts.

    The firmware accumulates the step times with their fractions and switches at the nearest tick, so errors stay below
    a tick.

    Args:
        frame: lamp frame.
        tick_rate: actual clock of the lamp's timer [1/s].
    """
    symbols = np.concatenate([_played_symbols(section, frame.marker) for section in frame.sections])
    places = [_places(train, len(frame.wheel)) for train in frame.trains]
    times = [np.full(train.steps, train.step_time, np.int64) for train in frame.trains]
    ends = np.cumsum(np.concatenate([times[s] for s in symbols]))
    states = np.array(frame.wheel)[np.concatenate([places[s] for s in symbols])]
    changes = np.append(True, states[1:] != states[:-1])
    starts = np.append(0, ends[:-1])[changes]
    ticks = (starts + STEP_FRACTION // 2) // STEP_FRACTION
    levels = (states[changes, None] >> np.arange(2) & 1).astype(float)
    return Waveform(ticks / tick_rate, levels, float(ends[-1] / STEP_FRACTION / tick_rate))


def _played_symbols(section: Section, marker: tuple[int, ...]) -> NDArray[np.int64]:
    heads = np.tile(np.array(marker, np.int64), (len(section.symbols), 1))
    groups = np.hstack([heads, section.symbols])
    return np.repeat(groups, section.repeats, axis=0).ravel()


def _places(train: Train, wheel_length: int) -> NDArray[np.int64]:
    return (train.first_place + np.arange(train.steps)) % wheel_length
