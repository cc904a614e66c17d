"""Serial commands that the LED beacon firmware rejects while it continues to transmit."""

from collections.abc import Callable, Iterator
from pathlib import Path

import numpy as np
import pytest
from lamp_frame_reading import frame_from_bytes
from simulated_lamp import TONE, SimulatedLamp, status_of

from vlc_beacon.core.packet.data_packet import IdPacket, crc16
from vlc_beacon.core.transmitter.lamp_frame import LENGTH_MAX, frame_to_bytes
from vlc_beacon.core.transmitter.lamp_program import ufsook_frame
from vlc_beacon.core.vlc_beacon_error import LampFrameError

pytestmark = pytest.mark.newest_set_only

ID = IdPacket(4711).to_bytes()


def with_crc(body: bytes) -> bytes:
    return body + crc16(body).to_bytes(2)


def edited(at: int, *values: int) -> bytes:
    body = bytearray(TONE[:-2])
    body[at : at + len(values)] = bytes(values)
    return with_crc(bytes(body))


REFUSED = {
    'a wrong checksum': (TONE[:-1] + bytes([TONE[-1] ^ 1]), 'crc'),
    'another version': (edited(0, 2), 'version'),
    'another length': (edited(2, len(TONE) - 1), 'length'),
    'no wheel': (edited(6, 0), 'header'),
    'a large wheel': (edited(6, 9), 'header'),
    'no bits': (edited(7, 0), 'header'),
    'more bits than symbols': (edited(7, 2), 'header'),
    'more symbols than bytes': (edited(8, 12), 'trains'),
    'too many symbols': (edited(8, 200), 'header'),
    'a long marker': (edited(9, 3), 'header'),
    'a marker that is no symbol': (edited(9, 1, 2), 'header'),
    'a short step': (edited(12, 0, 0, 0xE7, 0x03), 'trains'),
    'a long step': (edited(12, 0, 0, 0xFF, 0xFF), 'trains'),
    'no steps': (edited(16, 0, 0), 'trains'),
    'a place off the wheel': (edited(18, 2), 'trains'),
    'no groups': (edited(26, 0), 'sections'),
    'no repeats': (edited(27, 0), 'sections'),
    'no symbols': (edited(28, 0, 0), 'sections'),
    'more symbols than there are': (edited(28, 9, 0), 'sections'),
    'very many symbols': (edited(26, 255, 1, 255, 255), 'sections'),
    'no packet': (with_crc(TONE[:2] + bytes([28]) + TONE[3:26]), 'sections'),
    'half a packet': (with_crc(TONE[:2] + bytes([30]) + TONE[3:28]), 'sections'),
    'a header only': (with_crc(TONE[:10]), 'length'),
}


@pytest.fixture(scope='module')
def lamp(firmware: Path, tmp_path_factory: pytest.TempPathFactory) -> Iterator[SimulatedLamp]:
    """A lamp that plays a tone and goes on doing so whatever happens."""
    lamp = SimulatedLamp(firmware, tmp_path_factory.mktemp('lamp') / 'eeprom.bin')
    lamp.load(TONE)
    lamp.run(0.01)
    yield lamp
    lamp.run(0.01)
    assert lamp.ask('s') == status_of(TONE)
    assert lamp.power_off().tones() == [2000]


@pytest.mark.parametrize('fault', REFUSED)
def test_bad_frame_is_refused_with_a_reason(lamp: SimulatedLamp, fault: str) -> None:
    frame, reason = REFUSED[fault]
    for keep in (False, True):
        *others, last = lamp.load(frame, keep=keep)
        assert set(others) == {'OK'}
        assert last == f'ERR {reason}'


def test_damaged_frames_are_refused(lamp: SimulatedLamp) -> None:
    rng = np.random.default_rng(4)
    frame = np.frombuffer(frame_to_bytes(ufsook_frame([ID])), np.uint8)
    for _ in range(20):
        damage = np.packbits(rng.random(8 * len(frame)) < rng.choice([0.003, 0.03, 0.5]))
        if damage.any():
            assert lamp.load((frame ^ damage).tobytes())[-1].startswith('ERR')


LONG, FAR = f'b {LENGTH_MAX + 1}', f'b {0x10000 + len(TONE)}'
CONVERSATIONS = [
    [(LONG, 'ERR length'), (FAR, 'ERR length'), ('b 0', 'ERR length')],
    [('b 4', 'OK'), ('d 0 0102030405', 'ERR length')],
    [('x', 'ERR command'), ('d' * 200, 'ERR line'), ('v', f'led_beacon 1 {LENGTH_MAX}')],
    [('b 8', 'OK'), ('d 1 00', 'ERR offset'), (f'd {0x10000} 00', 'ERR offset'), ('d 0', 'ERR offset')],
    [('b 8', 'OK'), ('d 0 0g', 'ERR hex'), ('d 0 012', 'ERR hex'), ('d 0 0102', 'OK'), ('d 0 0102', 'OK')],
    [('b 8', 'OK'), ('d 0 0102', 'OK'), ('k', 'ERR length'), ('k', 'ERR begin'), ('d 0 00', 'ERR begin')],
]


@pytest.mark.parametrize('conversation', CONVERSATIONS)
def test_bad_lines_are_refused(lamp: SimulatedLamp, conversation: list[tuple[str, str]]) -> None:
    assert [lamp.ask(request) for request, _ in conversation] == [answer for _, answer in conversation]


def test_lamp_and_host_refuse_the_same_frames(power_up: Callable[[], SimulatedLamp]) -> None:
    rng = np.random.default_rng(6)
    body = frame_to_bytes(ufsook_frame([ID]))[:-2]
    lamp, answers = power_up(), []
    for _ in range(150):
        changed = bytearray(body)
        changed[rng.integers(44)] = rng.choice([0, 1, 2, 3, 4, 64, 255])
        frame = with_crc(bytes(changed))
        try:
            frame_from_bytes(frame)
            expected = 'OK'
        except LampFrameError:
            expected = 'ERR'
        # What is accepted goes out of the way of the next one.
        lamp.ask('h')
        answers.append(lamp.load(frame, keep=False)[-1].split()[0])
        assert answers[-1] == expected, frame.hex()
    assert min(answers.count('OK'), answers.count('ERR')) > 30
