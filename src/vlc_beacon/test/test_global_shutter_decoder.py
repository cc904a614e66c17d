import numpy as np
import pytest

from vlc_beacon.core.lamp_image.lamp_tracker import LampSample
from vlc_beacon.core.light_code.ufsook import ufsook_waveform
from vlc_beacon.core.packet.id_packet import IdPacket
from vlc_beacon.core.receiver.global_shutter_decoder import GlobalShutterDecoder
from vlc_beacon.core.receiver.lamp_decoder import LampView

EXPOSURE = 5e-4
NOTHING = np.zeros((16, 16), np.uint8)


@pytest.mark.parametrize('order', [1, -1])
def test_it_does_not_matter_which_half_is_taken_for_the_first(order: int) -> None:
    """Each packet is told once in a round, whichever way the panel hangs."""
    light, rng = ufsook_waveform([IdPacket(300).to_bytes()], 1.00003), np.random.default_rng(1)
    decoder, packets = GlobalShutterDecoder(EXPOSURE), []
    for stamp in np.arange(0.0, 12.0, 1.0 / 60.0).tolist():
        half_brightness = light.exposure_means(stamp, EXPOSURE)[::order] + 0.02 * rng.normal(size=2)
        sample = LampSample(1, np.zeros(2), np.full(2, 0.1), 8.0, half_brightness, None, 0)
        packets += [got.packet for got in decoder.read(LampView(stamp, NOTHING, sample, 0.0))]
    assert set(packets) == {IdPacket(300)}
    rounds = 12.0 / light.period
    assert 0.6 * rounds <= len(packets) <= rounds + 2
