"""Waveform of a lamp frame, with the tick resolution of the firmware."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from shirube_core.waveform import Waveform
from vlc_beacon.core.transmitter.lamp_frame import STEP_FRACTION, TICK_RATE, LampFrame, PulseTrain, Section


def waveform_from_frame(frame: LampFrame, tick_rate: float = TICK_RATE) -> Waveform:
    """Return the waveform of a frame, with two parts.

    The firmware accumulates the step times with their fractions and switches at the nearest tick, so errors stay below
    a tick.

    Args:
        frame: lamp frame.
        tick_rate: actual clock of the lamp's timer [1/s].
    """
    symbols = np.concatenate([_transmitted_symbols(section, frame.preamble) for section in frame.sections])
    state_indices = [_state_indices(train, len(frame.pattern)) for train in frame.pulse_trains]
    times = [np.full(train.steps, train.step_time, np.int64) for train in frame.pulse_trains]
    ends = np.cumsum(np.concatenate([times[s] for s in symbols]))
    states = np.array(frame.pattern)[np.concatenate([state_indices[s] for s in symbols])]
    changes = np.append(True, states[1:] != states[:-1])
    starts = np.append(0, ends[:-1])[changes]
    ticks = (starts + STEP_FRACTION // 2) // STEP_FRACTION
    levels = (states[changes, None] >> np.arange(2) & 1).astype(float)
    return Waveform(ticks / tick_rate, levels, float(ends[-1] / STEP_FRACTION / tick_rate))


def _transmitted_symbols(section: Section, preamble: tuple[int, ...]) -> NDArray[np.int64]:
    preambles = np.tile(np.array(preamble, np.int64), (len(section.symbols), 1))
    bursts = np.hstack([preambles, section.symbols])
    return np.repeat(bursts, section.repeats, axis=0).ravel()


def _state_indices(train: PulseTrain, pattern_length: int) -> NDArray[np.int64]:
    return (train.first_index + np.arange(train.steps)) % pattern_length
