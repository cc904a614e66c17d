import numpy as np
from lamp_frame_reading import frame_from_bytes, waveform_from_frame
from light_channel import seen_by_global_shutter

from vlc_beacon.core.light_code.ufsook import UfsookDecoder
from vlc_beacon.core.packet.id_packet import IdPacket
from vlc_beacon.core.transmitter.lamp_frame import frame_to_bytes
from vlc_beacon.core.transmitter.lamp_program import ufsook_frame

ID = IdPacket(1234)


def light_of(frame, tick_rate: float = 16e6):
    return waveform_from_frame(frame_from_bytes(frame_to_bytes(frame)), tick_rate)


def test_a_resonators_error_is_read_only_where_the_frame_knows_it() -> None:
    true_rate = 16e6 * 1.004
    for known, expected in ((16e6, set()), (true_rate, {ID})):
        light = light_of(ufsook_frame([ID.to_bytes()], 0, known), true_rate)
        seen = seen_by_global_shutter(light, 15.0, np.random.default_rng(2))
        assert {got.packet for got in UfsookDecoder().add_frames(*seen, 5e-4)} == expected
