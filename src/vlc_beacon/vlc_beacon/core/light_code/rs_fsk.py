"""RS-FSK: rolling shutter frequency shift keying, for lamps that cover few rows.

A symbol is a tone: eight tones carry three bits, a ninth is the preamble. A symbol lasts two frames, so each is sampled
at least once. The lowest tone shows one cycle in 16 rows of a typical phone (18.9 us per row).
"""

from collections.abc import Collection, Mapping
from functools import lru_cache
from itertools import pairwise

import numpy as np
from numpy.typing import NDArray

from shirube_core.waveform import Waveform, waveform_from_steps
from vlc_beacon.core.lamp_image.row_profile import LampRows
from vlc_beacon.core.light_code.symbol_code import SymbolCode
from vlc_beacon.core.light_code.symbol_receiver import SymbolReceiver
from vlc_beacon.core.packet.packet_reader import ReceivedPacket

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
    """Return the periodic waveform of packets for the slowest camera [1/s]; see `ufsook_waveform`."""
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


PHASES = 48
ROWS_MIN = 5
"""Minimum number of rows."""
RESIDUAL_FLOOR = 0.02
"""Minimum residual as a fraction of the variance, because lamps are not uniform."""
LOG_LIKELIHOOD_MIN = -40.0
"""Lower bound of the log-likelihood of one frame, relative to the best tone."""


def tone_log_likelihoods(rows: LampRows, tones: tuple[float, ...]) -> NDArray[np.float64]:
    """Return the log-likelihood of each tone [Hz] relative to the best one, shape (frames, n), 0 for the best.

    A square wave, blurred by the exposure, is fitted with the best phase, gain and offset; the residual gives the
    likelihood. One cycle in view suffices, which a spectrum would not resolve. All are 0 for uniform or too few rows.
    """
    frames, count = rows.brightness.shape
    seen = rows.brightness - rows.brightness.mean(axis=1, keepdims=True)
    powers = (seen**2).sum(axis=1)
    if count < ROWS_MIN:
        return np.zeros((frames, len(tones)))
    templates = _tone_templates(count, rows.row_time, round(rows.exposure, 6), tones)
    fits = np.maximum(seen @ templates.reshape(-1, count).T, 0.0).reshape(frames, len(tones), PHASES).max(axis=2)
    explained = fits**2 / np.where(powers > 0.0, powers, np.inf)[:, None]
    # The noise is unknown; its maximum likelihood estimate for each tone is the residual.
    likelihoods = -0.5 * (count - 3) * np.log(1.0 - explained + RESIDUAL_FLOOR)
    return np.maximum(likelihoods - likelihoods.max(axis=1, keepdims=True), LOG_LIKELIHOOD_MIN)


@lru_cache(maxsize=32)
def _tone_templates(rows: int, row_time: float, exposure: float, tones: tuple[float, ...]) -> NDArray[np.float32]:
    """Return zero-mean unit-norm templates of each tone in each phase, shape (n, PHASES, rows)."""
    templates = []
    for tone in tones:
        blinks = waveform_from_steps([0.5 / tone, 0.5 / tone], [1.0, 0.0])
        starts = np.arange(rows) * row_time + np.arange(PHASES)[:, None] / PHASES / tone
        templates.append(blinks.exposure_means(starts, exposure)[..., 0])
    seen = np.stack(templates)
    seen -= seen.mean(axis=2, keepdims=True)
    lengths = np.linalg.norm(seen, axis=2, keepdims=True)
    # Templates that are almost constant are disabled.
    visible = lengths > 1e-3 * np.sqrt(rows)
    return np.where(visible, seen / np.maximum(lengths, 1e-12), 0.0).astype(np.float32)


TIMING_PHASES = 24
TONE_MARGIN = 8.0
"""Minimum log-likelihood ratio between the best tone and the runner-up."""
TONE_SEPARATION_MIN = 200.0
"""Minimum separation between the tones of two lamps [Hz]."""
UNKNOWN_TONE_MAX = 11000.0
"""Highest unknown tone considered [Hz]; typical exposures suppress higher ones."""


class RsFskDecoder:
    """Decodes one lamp that was encoded for a frame rate [1/s]."""

    def __init__(self, frame_rate: float) -> None:
        code = rs_fsk_code(frame_rate)
        self._tones = symbol_tones(code)
        self._receiver = SymbolReceiver(code, symbols=PREAMBLE_SYMBOL + 1, bins=1, candidates=TIMING_PHASES)

    def add_frames(self, rows: LampRows) -> list[ReceivedPacket]:
        """Add frames and return the packets that they complete; invalid frames are skipped."""
        rows = rows.drop_invalid_frames()
        tables = tone_log_likelihoods(rows, self._tones).astype(np.float32)[:, None]
        return self._receiver.add(rows.centre_times, tables)


class ToneDecoder:
    """Identifies which known lamp sends a constant tone, for lamps without packets.

    An unknown lamp may send any tone. Unknown tones in the gaps between the known ones are alternative hypotheses, so a
    lamp is identified only if its tone is more likely than those. A threshold on the residual would not work: it
    depends on the number of rows and on the noise.

    Args:
        tone_by_beacon: tone of each beacon by ID [Hz]; at least two, separated by `TONE_SEPARATION_MIN` or more.
    """

    def __init__(self, tone_by_beacon: Mapping[int, float]) -> None:
        self._beacons = tuple(tone_by_beacon)
        known = tuple(tone_by_beacon.values())
        self._tones = known + _unknown_tones(known)
        self._sums = np.zeros(len(self._tones))

    def add_frames(self, rows: LampRows) -> int | None:
        """Add frames and return the identified beacon, or None while it is ambiguous."""
        self._sums += tone_log_likelihoods(rows.drop_invalid_frames(), self._tones).sum(axis=0)
        ordered = np.argsort(self._sums)
        if self._sums[ordered[-1]] - self._sums[ordered[-2]] < TONE_MARGIN:
            return None
        self._sums[:] = 0.0
        return self._beacons[ordered[-1]] if ordered[-1] < len(self._beacons) else None


def _unknown_tones(known: Collection[float]) -> tuple[float, ...]:
    """Return unknown tones in the gaps between known ones, at least `TONE_SPACING` from any other tone [Hz]."""
    edges = [0.0, *sorted(known), max(UNKNOWN_TONE_MAX, *known) + 2.0 * TONE_SPACING]
    gaps = [np.linspace(low, high, max(int((high - low) / TONE_SPACING), 1) + 1) for low, high in pairwise(edges)]
    return tuple(np.concatenate([gap[1:-1] for gap in gaps]).tolist())
