"""Brightness of a lamp over time, and its exact mean over camera exposures."""

from light_waveform.light_waveform_error import LightWaveformError
from light_waveform.waveform import Waveform, steady_light, waveform_of_steps
from light_waveform.waveform_csv import csv_of_waveform, waveform_of_csv

__all__ = [
    'LightWaveformError',
    'Waveform',
    'csv_of_waveform',
    'steady_light',
    'waveform_of_csv',
    'waveform_of_steps',
]
