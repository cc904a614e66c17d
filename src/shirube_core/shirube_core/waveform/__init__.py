"""Brightness of a lamp over time, and its exact mean over camera exposures."""

from shirube_core.waveform.light_waveform_error import LightWaveformError
from shirube_core.waveform.waveform import Waveform, steady_light, waveform_from_steps
from shirube_core.waveform.waveform_csv import waveform_from_csv, waveform_to_csv

__all__ = [
    'LightWaveformError',
    'Waveform',
    'steady_light',
    'waveform_from_csv',
    'waveform_from_steps',
    'waveform_to_csv',
]
