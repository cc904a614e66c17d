from dataclasses import replace

import numpy as np
import pytest

from vlc_beacon.core.light_code.manchester import SlotFormat
from vlc_beacon.core.packet.crc import crc16
from vlc_beacon.core.packet.data_packet import DataPacket
from vlc_beacon.core.transmitter.coded_frame import (
    constant_tone_frame,
    manchester_frame,
    rs_fsk_frame,
    ufsook_frame,
)
from vlc_beacon.core.transmitter.lamp_frame import LampFrame
from vlc_beacon.core.transmitter.lamp_frame_bytes import LENGTH_MAX, bytes_of_frame, frame_of_bytes
from vlc_beacon.core.transmitter.lamp_frame_error import LampFrameError

HUNDRED = DataPacket(np.random.default_rng(0).bytes(100)).to_bytes()
FRAMES = {
    'ufsook': ufsook_frame([b'abc', HUNDRED], plays=3),
    'rs_fsk': rs_fsk_frame([b'abc', b'defg'], 30.0),
    'manchester': manchester_frame([b'abc', HUNDRED], SlotFormat(1)),
    'tone': constant_tone_frame(3000.0),
}


@pytest.mark.parametrize('code', FRAMES)
def test_bytes_hold_all_of_a_frame(code: str) -> None:
    frame = FRAMES[code]
    again = frame_of_bytes(bytes_of_frame(frame))
    plain = [replace(f, sections=[None]) for f in (frame, again)]
    assert plain[0] == plain[1]
    assert [s.repeats for s in again.sections] == [s.repeats for s in frame.sections]
    for one, other in zip(frame.sections, again.sections, strict=True):
        assert one.symbols.tolist() == other.symbols.tolist()


def test_bytes_are_as_documented() -> None:
    """The example of firmware/led_beacon/README.md: a tone of 4 kHz."""
    body = bytes.fromhex('0100 2100 0300 02 01 02 00 0000  0000d007 0200 00  0000d007 0200 00  01 01 0100 00')
    assert bytes_of_frame(constant_tone_frame(4000.0)) == body + crc16(body).to_bytes(2)


def test_a_hundred_bytes_fit_in_every_code() -> None:
    for slot_bytes in (1, 2, 3):
        assert len(bytes_of_frame(manchester_frame([HUNDRED], SlotFormat(slot_bytes)))) <= LENGTH_MAX
    assert len(bytes_of_frame(rs_fsk_frame([HUNDRED] * 3, 30.0))) <= LENGTH_MAX
    assert len(bytes_of_frame(ufsook_frame([HUNDRED] * 4))) <= LENGTH_MAX


def test_a_frame_too_long_is_refused() -> None:
    with pytest.raises(LampFrameError, match='the frame has 597 bytes, the limit is 508; send fewer packets'):
        bytes_of_frame(ufsook_frame([HUNDRED] * 5))


@pytest.mark.parametrize('code', FRAMES)
def test_damage_is_noticed(code: str) -> None:
    data = bytes_of_frame(FRAMES[code])
    for at in range(len(data)):
        with pytest.raises(LampFrameError):
            frame_of_bytes(data[:at] + bytes([data[at] ^ 0x10]) + data[at + 1 :])
    for length in range(len(data)):
        with pytest.raises(LampFrameError):
            frame_of_bytes(data[:length])


def test_nonsense_with_a_right_checksum_is_refused_or_a_frame() -> None:
    rng = np.random.default_rng(1)
    body = bytes_of_frame(FRAMES['tone'])[:-2]
    refused = 0
    for _ in range(2000):
        changed = bytearray(body)
        for at in rng.integers(len(body), size=3):
            changed[at] = rng.integers(256)
        try:
            assert isinstance(frame_of_bytes(bytes(changed) + crc16(bytes(changed)).to_bytes(2)), LampFrame)
        except LampFrameError:
            refused += 1
    assert refused > 1000
