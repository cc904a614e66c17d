import pytest
from lamp_frame_reading import frame_from_bytes, waveform_from_frame
from light_channel import packets_in

from vlc_beacon.core.packet.data_packet import IdPacket
from vlc_beacon.core.transmitter.lamp_frame import frame_to_bytes
from vlc_beacon.core.transmitter.lamp_program import ufsook_frame

TRUE_RATE = 16e6 * 1.004


@pytest.mark.parametrize(('known', 'expected'), [(16e6, set()), (TRUE_RATE, {IdPacket(1234)})])
def test_a_resonators_error_is_read_only_where_the_frame_knows_it(known, expected) -> None:
    frame = frame_to_bytes(ufsook_frame([IdPacket(1234).to_bytes()], 0, known))
    light = waveform_from_frame(frame_from_bytes(frame), TRUE_RATE)
    assert set(packets_in(light, 'ufsook', 15.0, 2)) == expected
