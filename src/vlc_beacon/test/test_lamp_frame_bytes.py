from dataclasses import replace

import numpy as np
import pytest

from vlc_beacon.core.light_code.manchester import SegmentFormat
from vlc_beacon.core.packet.crc import crc16
from vlc_beacon.core.packet.data_packet import DataPacket
from vlc_beacon.core.transmitter.coded_frame import (
    constant_tone_frame,
    manchester_frame,
    rs_fsk_frame,
    ufsook_frame,
)
from vlc_beacon.core.transmitter.lamp_frame import LampFrame
from vlc_beacon.core.transmitter.lamp_frame_bytes import LENGTH_MAX, frame_from_bytes, frame_to_bytes
from vlc_beacon.core.transmitter.lamp_frame_error import LampFrameError

HUNDRED = DataPacket(np.random.default_rng(0).bytes(100)).to_bytes()
FRAMES = {
    'ufsook': ufsook_frame([b'abc', HUNDRED], plays=3),
    'rs_fsk': rs_fsk_frame([b'abc', b'defg'], 30.0),
    'manchester': manchester_frame([b'abc', HUNDRED], SegmentFormat(1)),
    'tone': constant_tone_frame(3000.0),
}


@pytest.mark.parametrize('code', FRAMES)
def test_bytes_hold_all_of_a_frame(code: str) -> None:
    frame = FRAMES[code]
    again = frame_from_bytes(frame_to_bytes(frame))
    plain = [replace(f, sections=[None]) for f in (frame, again)]
    assert plain[0] == plain[1]
    assert [s.repeats for s in again.sections] == [s.repeats for s in frame.sections]
    for one, other in zip(frame.sections, again.sections, strict=True):
        assert one.symbols.tolist() == other.symbols.tolist()


def test_bytes_are_as_documented() -> None:
    """The example of firmware/led_beacon/README.md: a tone of 4 kHz."""
    body = bytes.fromhex('0100 2100 0300 02 01 02 00 0000  0000d007 0200 00  0000d007 0200 00  01 01 0100 00')
    assert frame_to_bytes(constant_tone_frame(4000.0)) == body + crc16(body).to_bytes(2)


def test_a_hundred_bytes_fit_in_every_code() -> None:
    for segment_bytes in (1, 2, 3):
        assert len(frame_to_bytes(manchester_frame([HUNDRED], SegmentFormat(segment_bytes)))) <= LENGTH_MAX
    assert len(frame_to_bytes(rs_fsk_frame([HUNDRED] * 3, 30.0))) <= LENGTH_MAX
    assert len(frame_to_bytes(ufsook_frame([HUNDRED] * 4))) <= LENGTH_MAX


def test_a_too_long_frame_is_rejected() -> None:
    with pytest.raises(LampFrameError, match='the frame has 597 bytes, the limit is 508; send fewer packets'):
        frame_to_bytes(ufsook_frame([HUNDRED] * 5))


@pytest.mark.parametrize('code', FRAMES)
def test_damage_is_noticed(code: str) -> None:
    data = frame_to_bytes(FRAMES[code])
    for at in range(len(data)):
        with pytest.raises(LampFrameError):
            frame_from_bytes(data[:at] + bytes([data[at] ^ 0x10]) + data[at + 1 :])
    for length in range(len(data)):
        with pytest.raises(LampFrameError):
            frame_from_bytes(data[:length])


def test_random_bytes_with_a_correct_checksum_are_rejected_or_parsed() -> None:
    rng = np.random.default_rng(1)
    body = frame_to_bytes(FRAMES['tone'])[:-2]
    refused = 0
    for _ in range(2000):
        changed = bytearray(body)
        for at in rng.integers(len(body), size=3):
            changed[at] = rng.integers(256)
        try:
            assert isinstance(frame_from_bytes(bytes(changed) + crc16(bytes(changed)).to_bytes(2)), LampFrame)
        except LampFrameError:
            refused += 1
    assert refused > 1000
