"""Visible flicker of a waveform, for tests."""

import numpy as np

from shirube_core.waveform import Waveform


def worst_flicker(waveform: Waveform, *, whole: bool = False, highest: float = 90.0) -> float:
    """Return the strongest line up to a frequency [Hz] over what IEEE 1789-2015 calls low risk.

    That is a modulation of 2.5 % for each 100 Hz, which 90 Hz and slower lines must not exceed; ``whole`` looks at all
    parts of the lamp together rather than at the worst of them.
    """
    frequencies = np.arange(1, int(highest * waveform.period) + 1) / waveform.period
    edges = np.append(waveform.times, waveform.period)
    levels = waveform.levels.mean(axis=1, keepdims=True) if whole else waveform.levels
    mean = np.diff(edges) @ levels / waveform.period
    worst = 0.0
    for frequency in frequencies:
        integrals = np.diff(np.exp(-2j * np.pi * frequency * edges)) / (2.0 * np.pi * frequency)
        modulation = 2.0 * np.abs(integrals @ levels) / waveform.period / mean
        worst = max(worst, float(modulation.max()) / (0.00025 * frequency))
    return worst
