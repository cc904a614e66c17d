import numpy as np
import pytest

from vlc_beacon.core.light_code.manchester import SegmentFormat, segments_waveform
from vlc_beacon.core.light_code.reed_solomon_block import segments_from_packet
from vlc_beacon.core.light_code.rs_fsk import constant_tone_waveform, rs_fsk_waveform
from vlc_beacon.core.light_code.ufsook import ufsook_waveform
from vlc_beacon.core.packet.data_packet import DataPacket
from vlc_beacon.core.transmitter.coded_frame import (
    constant_tone_frame,
    manchester_frame,
    rs_fsk_frame,
    ufsook_frame,
)
from vlc_beacon.core.transmitter.lamp_frame_waveform import waveform_from_frame

PACKETS = [b'abc', DataPacket(np.random.default_rng(0).bytes(100)).to_bytes(), b'\x00\xff']
SLOTS = SegmentFormat(2, 1.0 / 7000.0, 60.0)


def pair_of(code: str, tick_rate: float):
    """Return a code's frame and the waveform that it is to play."""
    match code:
        case 'ufsook':
            return ufsook_frame(PACKETS, 0, tick_rate), ufsook_waveform(PACKETS)
        case 'rs_fsk':
            return rs_fsk_frame(PACKETS, 30.0, 0, tick_rate), rs_fsk_waveform(PACKETS, 30.0)
        case 'manchester':
            segments = [
                segment for packet in PACKETS for segment in segments_from_packet(packet, SLOTS.segment_bytes)
            ]
            return manchester_frame(PACKETS, SLOTS, 0, tick_rate), segments_waveform(segments, SLOTS)
        case _:
            return constant_tone_frame(3333.0, tick_rate), constant_tone_waveform(3333.0)


@pytest.mark.parametrize('tick_rate', [16e6, 16.08e6])
@pytest.mark.parametrize('code', ['ufsook', 'rs_fsk', 'manchester', 'tone'])
def test_lamp_plays_the_codes_waveform_within_a_tick(code: str, tick_rate: float) -> None:
    """Whatever the lamp's clock truly is, once the frame is made for it."""
    frame, waveform = pair_of(code, tick_rate)
    played = waveform_from_frame(frame, tick_rate)
    assert (played.levels == np.broadcast_to(waveform.levels, played.levels.shape)).all()
    assert np.abs(played.times - waveform.times).max() * tick_rate < 1.0
    assert abs(played.period - waveform.period) * tick_rate < 1.0


def test_lamp_switches_at_whole_ticks() -> None:
    ticks = waveform_from_frame(pair_of('ufsook', 16e6)[0]).times * 16e6
    assert ticks == pytest.approx(np.round(ticks), abs=1e-6)
