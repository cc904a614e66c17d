import numpy as np
import pytest
from light_channel import seen_by_global_shutter

from vlc_beacon.core.light_code.gain_control import GainControl
from vlc_beacon.core.light_code.ufsook import ufsook_waveform
from vlc_beacon.core.light_code.ufsook_decoder import UfsookDecoder
from vlc_beacon.core.packet.id_packet import IdPacket


def test_grey_values_of_any_unit_are_read_as_well() -> None:
    waveform = ufsook_waveform([IdPacket(5).to_bytes()], 1.0001)
    stamps, seen = seen_by_global_shutter(waveform, 20.0, np.random.default_rng(0))
    # The halves differ a little, and the lamp gets brighter as the robot comes nearer.
    grey = np.array([8.0, 9.0]) + np.linspace(60.0, 110.0, len(stamps))[:, None] * seen * [1.0, 1.05]
    scale = GainControl()
    normalize = np.array([scale.normalize(one) for one in grey])
    assert np.abs(normalize[200:] - seen[200:]).mean() < 0.1
    got = UfsookDecoder().add_frames(stamps, normalize, 5e-4)
    assert {packet.packet for packet in got} == {IdPacket(5)}
    assert len(got) >= 18


@pytest.mark.parametrize('level', [0.0, 90.0])
def test_a_steady_lamp_carries_no_code(level: float) -> None:
    scale, rng = GainControl(), np.random.default_rng(0)
    assert all(np.isnan(scale.normalize(level * (1.0 + rng.normal(0.0, 0.01, 2)))).all() for _ in range(200))


def test_frames_without_the_lamp_are_ignored() -> None:
    with_gaps, without = GainControl(), GainControl()
    rng = np.random.default_rng(0)
    for k in range(100):
        grey = 100.0 * rng.integers(0, 2, 2)
        if k % 3 == 0:
            assert np.isnan(with_gaps.normalize([np.nan, 3.0])).all()
        assert with_gaps.normalize(grey) == pytest.approx(without.normalize(grey), nan_ok=True)
