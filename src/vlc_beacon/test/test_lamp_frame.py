from dataclasses import replace

import numpy as np
import pytest

from vlc_beacon.core.transmitter.coded_frame import constant_tone_frame, ufsook_frame
from vlc_beacon.core.transmitter.lamp_frame import STEP_FRACTION, PulseTrain, Section, pulse_train_of_duration
from vlc_beacon.core.transmitter.lamp_frame_error import LampFrameError

FRAME = ufsook_frame([b'abc'])


def test_invalid_steps_of_a_frame_are_rejected() -> None:
    with pytest.raises(LampFrameError, match='a step lasts 160 ticks, the firmware supports 1000 to 65000'):
        constant_tone_frame(50_000.0)
    with pytest.raises(LampFrameError, match='a step lasts 80000 ticks'):
        constant_tone_frame(100.0)
    with pytest.raises(LampFrameError, match='a symbol has 0 steps'):
        PulseTrain(0, 0, 2000 * STEP_FRACTION)


def test_invalid_packets_of_a_frame_are_rejected() -> None:
    for shape in ((0, 1), (256, 1), (1, 0), (1, 65536)):
        with pytest.raises(LampFrameError, match=f'{shape[0]} bursts of {shape[1]} symbols'):
            Section(np.zeros(shape, np.int64))
    with pytest.raises(LampFrameError, match='repeated 256 times'):
        Section(np.zeros((1, 1), np.int64), 256)


@pytest.mark.parametrize(
    ('change', 'message'),
    [
        ({'pattern': ()}, 'the pattern is'),
        ({'pattern': (4,)}, 'the pattern is'),
        ({'pattern': (3,)}, 'beyond the end of the pattern'),
        ({'bits': 0}, 'symbols are invalid for'),
        ({'bits': 3}, '4 symbols are invalid for data symbols of 3 bits'),
        ({'preamble': (4,)}, 'the preamble is'),
        ({'preamble': (1, 2, 3)}, 'the preamble is'),
        ({'plays': 256}, 'plays is 256'),
        ({'sections': []}, 'at least one packet'),
    ],
)
def test_invalid_frames_are_rejected(change, message) -> None:
    with pytest.raises(LampFrameError, match=message):
        replace(FRAME, **change)


def test_a_train_lasts_as_long_as_asked() -> None:
    train = pulse_train_of_duration(0, 56, 1.0 / 30.0, 16e6)
    assert train.steps * train.step_time / STEP_FRACTION == pytest.approx(16e6 / 30.0, abs=1e-3)
