"""The one exception root of the package."""

from __future__ import annotations


class LightWaveformError(ValueError):
    """What is given is no waveform; the message is one line that says why."""
