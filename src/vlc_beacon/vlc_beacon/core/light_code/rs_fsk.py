"""RS-FSK: rolling shutter frequency shift keying, for lamps that cover few rows.

A symbol is a tone: eight tones carry three bits, a ninth is the preamble. A symbol lasts two frames, so each is sampled
at least once. The lowest tone shows one cycle in 16 rows of a typical phone (18.9 us per row).
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from shirube_core.waveform import Waveform, waveform_from_steps
from vlc_beacon.core.light_code.symbol_code import SymbolCode

BITS = 3
PREAMBLE_SYMBOL = 1 << BITS
TONE_LOWEST = 3500.0
"""Lowest tone [Hz]."""
TONE_SPACING = 500.0
"""Tone spacing [Hz]; 200 Hz suffices for a constant tone, but not for symbols of two frames on 16 rows."""
FRAMES_PER_SYMBOL = 2


def rs_fsk_code(frame_rate: float) -> SymbolCode:
    """Return the code for cameras with at least this frame rate [1/s]."""
    return SymbolCode(BITS, (PREAMBLE_SYMBOL,), FRAMES_PER_SYMBOL / frame_rate)


def symbol_tones(code: SymbolCode) -> tuple[float, ...]:
    """Return the tone of each symbol [Hz], the preamble last; symbols hold whole cycles, so their mean is equal."""
    nominal = TONE_LOWEST + TONE_SPACING * np.arange(PREAMBLE_SYMBOL + 1)
    return tuple((np.round(nominal * code.duration) / code.duration).tolist())


def rs_fsk_waveform(packets: list[bytes], frame_rate: float, clock_scale: float = 1.0) -> Waveform:
    """Return the periodic waveform of a sequence of packets, with one part.

    Args:
        packets: encoded packets, at least one.
        frame_rate: frame rate of the slowest camera [1/s].
        clock_scale: actual over nominal duration, to simulate a clock error.
    """
    code = rs_fsk_code(frame_rate)
    symbols = np.concatenate([code.encode_symbols(packet) for packet in packets])
    return _waveform_from_tones(np.array(symbol_tones(code))[symbols], code.duration, clock_scale)


def constant_tone_waveform(tone: float) -> Waveform:
    """Return the waveform of a lamp that is identified by a constant tone [Hz]."""
    return waveform_from_steps([0.5 / tone, 0.5 / tone], [1.0, 0.0])


def _waveform_from_tones(tones: NDArray[np.float64], duration: float, clock_scale: float) -> Waveform:
    halves = np.round(2.0 * tones * duration).astype(int)
    durations = np.repeat(duration / halves * clock_scale, halves)
    return waveform_from_steps(durations, np.arange(len(durations)) % 2 == 0)
