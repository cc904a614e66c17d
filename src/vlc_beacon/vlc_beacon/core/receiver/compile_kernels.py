"""Compiles the numba kernels by decoding a synthetic lamp, so that the first image is not delayed."""

import numpy as np
from numpy.typing import NDArray

from shirube_core.waveform import Waveform
from vlc_beacon.core.lamp_image.row_profile import rows_from_frame
from vlc_beacon.core.light_code.manchester import SegmentFormat
from vlc_beacon.core.light_code.manchester_decoder import ManchesterDecoder
from vlc_beacon.core.light_code.rs_fsk import rs_fsk_waveform
from vlc_beacon.core.light_code.ufsook import FRAME_RATE, ufsook_waveform
from vlc_beacon.core.packet.data_packet import IdPacket
from vlc_beacon.core.receiver.light_receiver import LightReceiver
from vlc_beacon.core.settings import ReceiverSettings

_SECONDS = 1.6
"""Simulated time, enough for symbol timing recovery and an ID [s]."""
_SIDE, _RADIUS, _LEVEL = 96, 12.0, 200.0


def compile_kernels(settings: ReceiverSettings) -> None:
    """Compile the kernels for the shutter of the settings."""
    receiver = LightReceiver([], ReceiverSettings(settings.shutter))
    rate = settings.lamp_frame_rate if settings.is_rolling else FRAME_RATE
    packets = [IdPacket(1).to_bytes()]
    light = rs_fsk_waveform(packets, rate) if settings.is_rolling else ufsook_waveform(packets)
    for stamp in np.arange(0.0, _SECONDS, 1.0 / rate).tolist():
        receiver.receive(stamp, _image(light, stamp, settings))
    if settings.is_rolling:
        segments = SegmentFormat()
        count = segments.rows_min(settings.row_time, settings.exposure_time)
        rows = np.random.default_rng(0).uniform(size=count)
        seen = rows_from_frame(0.0, 0, rows, settings.row_time, settings.exposure_time)
        ManchesterDecoder(segments).add_frames(seen)


def _image(light: Waveform, stamp: float, settings: ReceiverSettings) -> NDArray[np.uint8]:
    """Return an image of a disc, shape (_SIDE, _SIDE), modulated by halves or rows."""
    v, u = np.indices((_SIDE, _SIDE)) - 0.5 * _SIDE
    if settings.is_rolling:
        fractions = light.exposure_means(stamp + np.arange(_SIDE) * settings.row_time, settings.exposure_time)
    else:
        first, second = light.exposure_means(stamp, settings.exposure_time)
        fractions = np.where(u < 0.0, first, second)
    return np.where(np.hypot(u, v) < _RADIUS, _LEVEL * fractions, 4.0).astype(np.uint8)
