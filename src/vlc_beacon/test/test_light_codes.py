"""What holds for every light code: packets in turn, none wrong or twice, frames one by one or together."""

import numpy as np
import pytest
from light_channel import COMMAND, SEGMENTS, one_by_one, received, waveform_of
from light_channel import seen_by_global_shutter as global_shutter
from light_channel import seen_by_rolling_shutter as rolling_shutter

from vlc_beacon.core.light_code.manchester_decoder import ManchesterDecoder
from vlc_beacon.core.light_code.ufsook import UfsookDecoder
from vlc_beacon.core.packet.data_packet import DataPacket, IdPacket

ID = IdPacket(3)
TEXT = DataPacket('曲がる'.encode(), is_text=True)


@pytest.mark.parametrize(
    ('code', 'packets', 'seconds', 'counts'),
    [
        ('ufsook', [ID, ID, COMMAND], 40.0, (8, 4)),
        ('rs_fsk', [ID, ID, COMMAND], 40.0, (5, 5)),
        ('manchester', [ID, COMMAND], 30.0, (20, 20)),
        ('ufsook', [TEXT], 20.0, ()),
    ],
)
def test_packets_may_take_turns(code, packets, seconds, counts) -> None:
    got = received(code, packets, seconds, 3, 100.0)
    assert set(got) == set(packets)
    assert all(got.count(packet) >= least for packet, least in zip((ID, COMMAND), counts))


@pytest.mark.parametrize(
    ('code', 'packets', 'seconds', 'channel', 'least'),
    [
        ('ufsook', [ID], 26.0, {'ppm': 100.0, 'lost': 0.05}, 10),
        ('ufsook', [ID], 26.0, {'ppm': 100.0, 'snr': 3.0}, 0),
        ('rs_fsk', [ID], 18.0, {'lost': 0.05}, 1),
        ('rs_fsk', [ID], 18.0, {'snr': 5.0}, 0),
        ('manchester', [COMMAND], 20.0, {'snr': 1.5}, 0),
        ('manchester', [COMMAND, ID], 30.0, {'lost': 0.5}, 0),
    ],
)
def test_lost_frames_and_noise_make_no_wrong_packets(code, packets, seconds, channel, least) -> None:
    for seed in range(4 if code == 'manchester' else 6):
        got = received(code, packets, seconds, seed, **channel)
        assert set(got) <= set(packets)
        assert len(got) >= least


def test_frames_give_the_same_one_by_one_and_together() -> None:
    rng = np.random.default_rng(4)
    stamps, halves = global_shutter(waveform_of('ufsook', [ID], 100.0), 30.0, rng, lost=0.02)
    rows = rolling_shutter(waveform_of('manchester', [COMMAND]), 10.0, rng, rows=304, lost=0.05)
    ufsook = [(stamp[None], pair[None], 5e-4) for stamp, pair in zip(stamps, halves)]
    for new, whole, singles, least in (
        (UfsookDecoder, (stamps, halves, 5e-4), ufsook, 20),
        (lambda: ManchesterDecoder(SEGMENTS), (rows,), [(one,) for one in one_by_one(rows)], 7),
    ):
        decoder, together = new(), new().add_frames(*whole)
        assert [packet for single in singles for packet in decoder.add_frames(*single)] == together
        assert len(together) > least
