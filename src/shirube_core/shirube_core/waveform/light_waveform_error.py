"""The root exception of the package."""

from __future__ import annotations


class LightWaveformError(ValueError):
    """Invalid waveform; the message is one line with the cause."""
