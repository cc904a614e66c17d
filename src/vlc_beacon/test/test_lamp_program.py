import numpy as np
from lamp_frame_reading import frame_from_bytes, waveform_from_frame
from light_channel import seen_by_global_shutter, seen_by_rolling_shutter

from vlc_beacon.core.light_code.manchester import SegmentFormat
from vlc_beacon.core.light_code.manchester_decoder import ManchesterDecoder
from vlc_beacon.core.light_code.rs_fsk import RsFskDecoder
from vlc_beacon.core.light_code.ufsook import UfsookDecoder
from vlc_beacon.core.packet.id_packet import IdPacket
from vlc_beacon.core.transmitter.lamp_frame import frame_to_bytes
from vlc_beacon.core.transmitter.lamp_program import manchester_frame, rs_fsk_frame, ufsook_frame

ID = IdPacket(1234)


def light_of(frame, tick_rate: float = 16e6):
    return waveform_from_frame(frame_from_bytes(frame_to_bytes(frame)), tick_rate)


def test_receivers_read_what_a_lamp_would_play() -> None:
    rng = np.random.default_rng(1)
    packets, segments = [ID.to_bytes()], SegmentFormat(1)
    seen = seen_by_global_shutter(light_of(ufsook_frame(packets)), 10.0, rng)
    assert {got.packet for got in UfsookDecoder().add_frames(*seen, 5e-4)} == {ID}
    rows = seen_by_rolling_shutter(light_of(rs_fsk_frame(packets, 30.0)), 10.0, rng)
    assert {got.packet for got in RsFskDecoder(30.0).add_frames(rows)} == {ID}
    rows = seen_by_rolling_shutter(light_of(manchester_frame(packets, segments)), 10.0, rng, rows=304)
    assert {got.packet for got in ManchesterDecoder(segments).add_frames(rows)} == {ID}


def test_a_resonators_error_is_read_only_where_the_frame_knows_it() -> None:
    true_rate = 16e6 * 1.004
    for known, expected in ((16e6, set()), (true_rate, {ID})):
        light = light_of(ufsook_frame([ID.to_bytes()], 0, known), true_rate)
        seen = seen_by_global_shutter(light, 15.0, np.random.default_rng(2))
        assert {got.packet for got in UfsookDecoder().add_frames(*seen, 5e-4)} == expected
