"""Lamps and cameras for `light_channel`: what is played, what the camera takes of it, what the decoder reads."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import Protocol

import numpy as np
from numpy.typing import NDArray

from shirube_core.waveform import Waveform
from vlc_beacon.core.lamp_image.row_profile import LampRows
from vlc_beacon.core.light_code.code_profile import (
    CodeProfile,
    manchester_profile,
    rs_fsk_profile,
    ufsook_profile,
)
from vlc_beacon.core.light_code.manchester import SegmentFormat, segments_from_packet, segments_waveform
from vlc_beacon.core.light_code.manchester_decoder import ManchesterDecoder
from vlc_beacon.core.light_code.rs_fsk import RsFskDecoder, rs_fsk_waveform
from vlc_beacon.core.light_code.ufsook import UfsookDecoder, ufsook_waveform
from vlc_beacon.core.packet.packet_reader import ReceivedPacket

ROW_TIME = 18.9e-6
"""Of a phone [s]."""
TOGETHER = 500
"""Frames that are decoded in one go; one by one gives the same (a test shows it)."""


@dataclass(frozen=True)
class Channel:
    """Between lamp and decoder.

    Attributes:
        exposure: exposure time of a frame or row [s].
        rows: that the lamp covers, where the shutter rolls.
        snr: brightness of the lamp over the noise of a half of the panel, or of the mean of a row.
        clock_offset: frequency error of the lamp's clock [ppm].
        jitter: standard deviation of the frames' times [s].
        lost: share of frames that are dropped.
    """

    exposure: float
    rows: int = 0
    snr: float = 15.0
    clock_offset: float = 100.0
    jitter: float = 50e-6
    lost: float = 0.0


class Decoder(Protocol):
    """What reads frames: stamps (n,) and brightness (n, halves or rows)."""

    def __call__(self, stamps: NDArray[np.float64], seen: NDArray[np.float64], /) -> list[ReceivedPacket]:
        """Return the packets that the frames complete."""


@dataclass(frozen=True)
class Link:
    """A light code with a usual camera.

    Attributes:
        name: name in the tables.
        frame_rate: frame rate of the camera [1/s].
        default_channel: its channel.
        profile: what the code states.
        waveform: function that makes the waveform from packets and the clock's scale.
        decoder: a new one for a channel.
    """

    name: str
    frame_rate: float
    default_channel: Channel
    profile: CodeProfile
    waveform: Callable[[list[bytes], float], Waveform]
    decoder: Callable[[Channel], Decoder]

    def play(self, packets: list[bytes], channel: Channel) -> Waveform:
        """Return what the lamp plays, again and again."""
        return self.waveform(packets, 1.0 + channel.clock_offset * 1e-6)

    def simulate_reception(
        self, waveform: Waveform, stamps: NDArray[np.float64], channel: Channel, rng: np.random.Generator
    ) -> list[ReceivedPacket]:
        """Return what is read from frames at some times, shape (n,) [s]."""
        decode, packets = self.decoder(channel), []
        kept = stamps[rng.random(len(stamps)) >= channel.lost]
        for first in range(0, len(kept), TOGETHER):
            part = kept[first : first + TOGETHER]
            packets += decode(part, camera_brightness(waveform, part, channel, rng))
        return packets

    def stamps(self, seconds: float, rng: np.random.Generator) -> NDArray[np.float64]:
        """Return the times of the camera's frames, begun at any time [s]."""
        return rng.uniform(0.0, 1000.0) + np.arange(round(seconds * self.frame_rate)) / self.frame_rate


def camera_brightness(
    waveform: Waveform, stamps: NDArray[np.float64], channel: Channel, rng: np.random.Generator
) -> NDArray[np.float64]:
    """Return the brightness that a camera measures, shape (n, halves) or, where the shutter rolls, (n, rows)."""
    starts = stamps + rng.normal(0.0, channel.jitter, len(stamps))
    if channel.rows:
        seen = waveform.exposure_means(
            starts[:, None] + np.arange(channel.rows) * ROW_TIME, channel.exposure
        )[..., 0]
    else:
        seen = waveform.exposure_means(starts, channel.exposure)
    return seen + rng.normal(0.0, 1.0 / channel.snr, seen.shape)


def lamp_rows(stamps: NDArray[np.float64], seen: NDArray[np.float64], channel: Channel) -> LampRows:
    """Return frames in the form that decoders for rolling shutters take."""
    return LampRows(stamps, np.zeros(len(stamps), np.int64), seen, ROW_TIME, channel.exposure)


def ufsook_link() -> Link:
    """Return the link of a global shutter."""

    def decoder(channel: Channel) -> Decoder:
        reader = UfsookDecoder()
        return lambda stamps, seen: reader.add_frames(stamps, seen, channel.exposure)

    return Link('UFSOOK', 60.0, Channel(5e-4), ufsook_profile(), ufsook_waveform, decoder)


def rs_fsk_link() -> Link:
    """Return the link of a rolling shutter and the paper's small lamp."""
    rate = 30.0

    def decoder(channel: Channel) -> Decoder:
        reader = RsFskDecoder(rate)
        return lambda stamps, seen: reader.add_frames(lamp_rows(stamps, seen, channel))

    def waveform(packets: list[bytes], clock_scale: float) -> Waveform:
        return rs_fsk_waveform(packets, rate, clock_scale)

    profile = rs_fsk_profile(rate, ROW_TIME)
    return Link('RS-FSK', rate, Channel(60e-6, profile.rows_min), profile, waveform, decoder)


def manchester_link(segment_bytes: int) -> Link:
    """Return the link of a rolling shutter and a lamp that covers many rows."""
    segment_format, exposure = SegmentFormat(segment_bytes), 60e-6

    def decoder(channel: Channel) -> Decoder:
        reader = ManchesterDecoder(segment_format)
        return lambda stamps, seen: reader.add_frames(lamp_rows(stamps, seen, channel))

    def waveform(packets: list[bytes], clock_scale: float) -> Waveform:
        segments = [segment for packet in packets for segment in segments_from_packet(packet, segment_bytes)]
        return segments_waveform(segments, segment_format, clock_scale)

    profile = manchester_profile(segment_format, ROW_TIME, exposure)
    name = f'Manchester, {segment_bytes} B segments'
    return Link(name, 30.0, Channel(exposure, profile.rows_min), profile, waveform, decoder)
