"""Optical channel from waveform to camera samples and packets: exposure, clock offset, jitter, noise, lost frames."""

import numpy as np

from vlc_beacon.core.lamp_image.row_profile import LampRows
from vlc_beacon.core.light_code.manchester import SegmentFormat, segments_from_packet, segments_waveform
from vlc_beacon.core.light_code.manchester_decoder import ManchesterDecoder
from vlc_beacon.core.light_code.rs_fsk import RsFskDecoder, rs_fsk_waveform
from vlc_beacon.core.light_code.ufsook import UfsookDecoder, ufsook_waveform
from vlc_beacon.core.packet.command_packet import Command, CommandPacket
from vlc_beacon.core.packet.data_packet import DataPacket

COMMAND = CommandPacket(Command(3, 5, -1.570796, 77), b'abcd')
HUNDRED = DataPacket(np.random.default_rng(0).bytes(100))
SEGMENTS = SegmentFormat(1)


def seen_by_global_shutter(waveform, seconds, rng, *, exposure=5e-4, snr=15.0, jitter=5e-5, lost=0.0, frame_rate=60.0):
    """Return stamps (n,) and the brightness of both halves (n, 2)."""
    stamps = rng.uniform(0.0, 1000.0) + np.arange(round(seconds * frame_rate)) / frame_rate
    stamps = stamps[rng.random(len(stamps)) >= lost]
    seen = waveform.exposure_means(stamps + rng.normal(0.0, jitter, len(stamps)), exposure)
    return stamps, seen + rng.normal(0.0, 1.0 / snr, seen.shape)


def seen_by_rolling_shutter(
    waveform,
    seconds,
    rng,
    *,
    rows=16,
    row_time=18.9e-6,
    exposure=6e-5,
    snr=15.0,
    jitter=5e-5,
    lost=0.0,
    frame_rate=30.0,
):
    """Return the rows of all frames."""
    stamps = rng.uniform(0.0, 1000.0) + np.arange(round(seconds * frame_rate)) / frame_rate
    stamps = stamps[rng.random(len(stamps)) >= lost]
    starts = (stamps + rng.normal(0.0, jitter, len(stamps)))[:, None] + np.arange(rows) * row_time
    seen = waveform.exposure_means(starts, exposure)[..., 0]
    seen += rng.normal(0.0, 1.0 / snr, seen.shape)
    return LampRows(stamps, np.zeros(len(stamps), np.int64), seen, row_time, exposure)


def one_by_one(rows):
    """Yield each frame alone."""
    for i in range(len(rows.stamps)):
        frame = rows.stamps[[i]], rows.first_rows[[i]], rows.brightness[[i]]
        yield LampRows(*frame, rows.row_time, rows.exposure)


def waveform_of(code, packets, ppm=0.0, segments=SEGMENTS, rate=30.0):
    """Return the light of a lamp that plays packets in turn, with its clock too slow by so many millionths."""
    contents, scale = [packet.to_bytes() for packet in packets], 1.0 + 1e-6 * ppm
    if code == 'ufsook':
        return ufsook_waveform(contents, scale)
    if code == 'rs_fsk':
        return rs_fsk_waveform(contents, rate, scale)
    parts = [part for content in contents for part in segments_from_packet(content, segments.segment_bytes)]
    return segments_waveform(parts, segments, scale)


def packets_in(light, code, seconds, seed, segments=SEGMENTS, **channel):
    """Return the packets that a camera reads: UFSOOK through a global shutter, otherwise through a rolling one."""
    rng = np.random.default_rng(seed)
    if code == 'ufsook':
        frames = *seen_by_global_shutter(light, seconds, rng, **channel), channel.get('exposure', 5e-4)
        got = UfsookDecoder().add_frames(*frames)
    elif code == 'rs_fsk':
        rows = seen_by_rolling_shutter(light, seconds, rng, **channel)
        got = RsFskDecoder(channel.get('frame_rate', 30.0)).add_frames(rows)
    else:
        rows = seen_by_rolling_shutter(light, seconds, rng, **{'rows': 304, **channel})
        got = ManchesterDecoder(segments).add_frames(rows)
    return [received.packet for received in got]


def received(code, packets, seconds, seed, ppm=0.0, segments=SEGMENTS, **channel):
    """Return what a camera reads of packets that a lamp plays in turn."""
    light = waveform_of(code, packets, ppm, segments, channel.get('frame_rate', 30.0))
    return packets_in(light, code, seconds, seed, segments, **channel)
