"""What a lamp plays: brightness over time, and its exact mean over exposures."""

from light_waveform.light_waveform_error import LightWaveformError
from light_waveform.waveform import Waveform, steady_light, waveform_of_steps

__all__ = ['LightWaveformError', 'Waveform', 'steady_light', 'waveform_of_steps']
