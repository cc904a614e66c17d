from dataclasses import replace

import numpy as np
import pytest

from vlc_beacon.core.light_code.manchester import SegmentFormat
from vlc_beacon.core.packet.data_packet import DataPacket, crc16
from vlc_beacon.core.transmitter.lamp_frame import (
    LENGTH_MAX,
    STEP_FRACTION,
    PulseTrain,
    Section,
    frame_to_bytes,
    pulse_train_of_duration,
)
from vlc_beacon.core.transmitter.lamp_program import constant_tone_frame, manchester_frame, rs_fsk_frame, ufsook_frame
from vlc_beacon.core.vlc_beacon_error import LampFrameError

FRAME = ufsook_frame([b'abc'])


@pytest.mark.parametrize(
    ('make', 'message'),
    [
        (lambda: constant_tone_frame(50_000.0), 'a step lasts 160 ticks, the firmware supports 1000 to 65000'),
        (lambda: constant_tone_frame(100.0), 'a step lasts 80000 ticks'),
        (lambda: PulseTrain(0, 0, 2000 * STEP_FRACTION), 'a symbol has 0 steps'),
        (lambda: Section(np.zeros((0, 1), np.int64)), '0 bursts of 1 symbols'),
        (lambda: Section(np.zeros((256, 1), np.int64)), '256 bursts of 1 symbols'),
        (lambda: Section(np.zeros((1, 0), np.int64)), '1 bursts of 0 symbols'),
        (lambda: Section(np.zeros((1, 65536), np.int64)), '1 bursts of 65536 symbols'),
        (lambda: Section(np.zeros((1, 1), np.int64), 256), 'repeated 256 times'),
    ],
)
def test_invalid_steps_and_packets_of_a_frame_are_rejected(make, message) -> None:
    with pytest.raises(LampFrameError, match=message):
        make()


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


HUNDRED = DataPacket(np.random.default_rng(0).bytes(100)).to_bytes()


def test_bytes_are_as_documented() -> None:
    """The example of firmware/led_beacon/README.md: a tone of 4 kHz."""
    body = bytes.fromhex('0100 2100 0300 02 01 02 00 0000  0000d007 0200 00  0000d007 0200 00  01 01 0100 00')
    assert frame_to_bytes(constant_tone_frame(4000.0)) == body + crc16(body).to_bytes(2)


def test_a_hundred_bytes_fit_in_every_code_and_a_too_long_frame_is_rejected() -> None:
    frames = [manchester_frame([HUNDRED], SegmentFormat(size)) for size in (1, 2, 3)]
    frames += [rs_fsk_frame([HUNDRED] * 3, 30.0), ufsook_frame([HUNDRED] * 4)]
    assert all(len(frame_to_bytes(frame)) <= LENGTH_MAX for frame in frames)
    with pytest.raises(LampFrameError, match='the frame has 597 bytes, the limit is 508; send fewer packets'):
        frame_to_bytes(ufsook_frame([HUNDRED] * 5))
