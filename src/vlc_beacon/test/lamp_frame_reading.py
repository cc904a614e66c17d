"""What the lamp makes of a frame: reads it as the firmware does, and computes the light with its ticks."""

import numpy as np

from shirube_core.waveform import Waveform
from vlc_beacon.core.packet.data_packet import crc16
from vlc_beacon.core.transmitter.lamp_frame import (
    HEADER,
    LENGTH_MAX,
    PREAMBLE_MAX,
    SECTION,
    STEP_FRACTION,
    TICK_RATE,
    TRAIN,
    VERSION,
    LampFrame,
    PulseTrain,
    Section,
)
from vlc_beacon.core.vlc_beacon_error import LampFrameError


def frame_from_bytes(data):
    """Parse a frame; raises `LampFrameError` if the firmware would reject the bytes."""
    if not HEADER.size + 2 <= len(data) <= LENGTH_MAX or crc16(data):
        raise LampFrameError('wrong length or checksum')
    version, plays, length, pattern, states, bits, trains, preamble_length, *preamble = HEADER.unpack_from(data)
    begin, end = HEADER.size + trains * TRAIN.size, length - 2
    if version != VERSION or length != len(data) or begin > end or preamble_length > PREAMBLE_MAX:
        raise LampFrameError('invalid header')
    rows = TRAIN.iter_unpack(data[HEADER.size : begin])
    return LampFrame(
        tuple(pattern >> 2 * i & 3 for i in range(states)),
        bits,
        tuple(PulseTrain(first, steps, step_time) for step_time, steps, first in rows),
        tuple(preamble[:preamble_length]),
        _sections(data[begin:end], bits),
        plays,
    )


def _sections(data, bits):
    sections = []
    while data:
        if len(data) < SECTION.size:
            raise LampFrameError('truncated')
        bursts, repeats, count = SECTION.unpack_from(data)
        total = bursts * count * bits
        end = SECTION.size + (total + 7) // 8
        if len(data) < end:
            raise LampFrameError('truncated')
        ones = np.unpackbits(np.frombuffer(data[SECTION.size : end], np.uint8))[:total]
        sections.append(Section(ones.reshape(bursts, count, bits) @ (1 << np.arange(bits)[::-1]), repeats))
        data = data[end:]
    return sections


def waveform_from_frame(frame, tick_rate=TICK_RATE):
    """Return the waveform of a frame, with two parts, for the actual clock of the timer [1/s].

    The firmware accumulates the step times with their fractions and switches at the nearest tick.
    """
    symbols = np.concatenate([_transmitted_symbols(section, frame.preamble) for section in frame.sections])
    indices = [(train.first_index + np.arange(train.steps)) % len(frame.pattern) for train in frame.pulse_trains]
    times = [np.full(train.steps, train.step_time, np.int64) for train in frame.pulse_trains]
    ends = np.cumsum(np.concatenate([times[s] for s in symbols]))
    states = np.array(frame.pattern)[np.concatenate([indices[s] for s in symbols])]
    changes = np.append(True, states[1:] != states[:-1])
    ticks = (np.append(0, ends[:-1])[changes] + STEP_FRACTION // 2) // STEP_FRACTION
    levels = (states[changes, None] >> np.arange(2) & 1).astype(float)
    return Waveform(ticks / tick_rate, levels, float(ends[-1] / STEP_FRACTION / tick_rate))


def _transmitted_symbols(section, preamble):
    preambles = np.tile(np.array(preamble, np.int64), (len(section.symbols), 1))
    return np.repeat(np.hstack([preambles, section.symbols]), section.repeats, axis=0).ravel()
