"""RS-FSK: frequency shift keying for rolling shutters, for lamps that cover few rows.

A symbol is a tone, eight tones carry three bits, a ninth is the marker. A symbol lasts two frames, so each is seen
once at least. The tones begin where 16 rows of a usual phone (18.9 us) show one cycle.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from light_waveform import Waveform, waveform_of_steps
from vlc_beacon.core.light_code.symbol_code import SymbolCode

BITS = 3
MARKER = 1 << BITS
TONE_LOWEST = 3500.0
"""[Hz]"""
TONE_SPACING = 500.0
"""[Hz]; 200 Hz would do for one lamp that plays one tone for long, not for symbols of two frames on 16 rows."""
FRAMES_A_SYMBOL = 2


def rs_fsk_code(frame_rate: float) -> SymbolCode:
    """Return the code for cameras of at least so many frames a second."""
    return SymbolCode(BITS, (MARKER,), FRAMES_A_SYMBOL / frame_rate)


def symbol_tones(code: SymbolCode) -> tuple[float, ...]:
    """Return the tone of each symbol [Hz], the marker's last: whole cycles fit into a symbol, so the mean is even."""
    wanted = TONE_LOWEST + TONE_SPACING * np.arange(MARKER + 1)
    return tuple((np.round(wanted * code.duration) / code.duration).tolist())


def rs_fsk_waveform(packets: list[bytes], frame_rate: float, clock_scale: float = 1.0) -> Waveform:
    """Return the waveform that plays packets one after the other, again and again, with one part.

    Args:
        packets: at least one.
        frame_rate: of the slowest camera that shall read it [1/s].
        clock_scale: duration over nominal duration of everything, to simulate an inexact clock.
    """
    code = rs_fsk_code(frame_rate)
    symbols = np.concatenate([code.symbols_of(packet) for packet in packets])
    return _waveform_of_tones(np.array(symbol_tones(code))[symbols], code.duration, clock_scale)


def constant_tone_waveform(tone: float) -> Waveform:
    """Return the waveform of a lamp that is told by its tone [Hz] alone."""
    return waveform_of_steps([0.5 / tone, 0.5 / tone], [1.0, 0.0])


def _waveform_of_tones(tones: NDArray[np.float64], duration: float, clock_scale: float) -> Waveform:
    halves = np.round(2.0 * tones * duration).astype(int)
    durations = np.repeat(duration / halves * clock_scale, halves)
    return waveform_of_steps(durations, np.arange(len(durations)) % 2 == 0)
