"""What the lamp's firmware does and what it refuses on its serial line."""

import os
import pty
import select
import threading
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from simulated_lamp import TICK_RATE, SimulatedLamp

from vlc_beacon.core.light_code.ufsook_decoder import UfsookDecoder
from vlc_beacon.core.packet.command_packet import Command, CommandPacket
from vlc_beacon.core.packet.crc import crc16
from vlc_beacon.core.packet.id_packet import IdPacket
from vlc_beacon.core.transmitter.coded_frame import constant_tone_frame, ufsook_frame
from vlc_beacon.core.transmitter.lamp_frame import LampFrame, Section
from vlc_beacon.core.transmitter.lamp_frame_bytes import LENGTH_MAX, bytes_of_frame, frame_of_bytes
from vlc_beacon.core.transmitter.lamp_frame_error import LampFrameError
from vlc_beacon.core.transmitter.serial_protocol import LampStatus, upload_requests
from vlc_beacon.core.vlc_beacon_error import VlcBeaconError
from vlc_beacon.lamp_port import LampPort

ID = IdPacket(4711).to_bytes()
TONE = bytes_of_frame(constant_tone_frame(2000.0))


def test_new_lamp_shines_steadily(firmware: Path, eeprom: Path) -> None:
    lamp = SimulatedLamp(firmware, eeprom)
    assert lamp.ask('s') == 'steady none 0 0000 0'
    assert lamp.ask('p') == 'ERR none'
    lamp.run(0.1)
    assert lamp.power_off().states.tolist() == [0, 3]


def test_lamp_stops_and_plays_again(firmware: Path, eeprom: Path) -> None:
    lamp = SimulatedLamp(firmware, eeprom)
    lamp.load(TONE)
    lamp.run(0.1)
    assert lamp.ask('h') == 'OK'
    assert lamp.ask('s') == f'steady kept {len(TONE)} {TONE[-2:].hex()} 0'
    lamp.run(0.5)
    assert lamp.ask('p') == 'OK'
    lamp.run(0.1)
    light = lamp.power_off()
    pauses = np.flatnonzero(np.diff(light.ticks) > TICK_RATE // 2)
    assert [int(light.states[i]) for i in pauses] == [3]
    assert len(light.ticks) > 700


def test_temporary_frame_gives_way_to_the_kept_one(firmware: Path, eeprom: Path) -> None:
    lamp = SimulatedLamp(firmware, eeprom)
    lamp.load(TONE)
    ten_times = bytes_of_frame(replace(constant_tone_frame(4000.0), plays=10))
    assert lamp.load(ten_times, keep=False)[-1] == 'OK'
    lamp.run(0.1)
    assert lamp.ask('s').startswith('playing kept')
    light = lamp.power_off()
    assert light.tones() == [2000, 4000, 2000]
    assert (np.diff(light.ticks[2:]) == 2000).sum() >= 2 * 10 - 1

    lamp = SimulatedLamp(firmware, eeprom)
    lamp.load(bytes_of_frame(constant_tone_frame(4000.0)), keep=False)
    assert lamp.ask('s').startswith('playing temporary')
    lamp.power_off()
    lamp = SimulatedLamp(firmware, eeprom)
    assert lamp.ask('s') == f'playing kept {len(TONE)} {TONE[-2:].hex()} 0'
    lamp.power_off()


def test_temporary_frame_is_played_to_its_end(firmware: Path, eeprom: Path) -> None:
    tones = [constant_tone_frame(tone) for tone in (3000.0, 4000.0)]
    both = LampFrame(
        wheel=tones[0].wheel,
        bits=1,
        trains=tuple(replace(tone.trains[0], steps=20) for tone in tones),
        marker=(),
        sections=[Section(np.array([[0]])), Section(np.array([[1]]))],
        plays=1,
    )
    lamp = SimulatedLamp(firmware, eeprom)
    lamp.load(TONE)
    lamp.load(bytes_of_frame(both), keep=False)
    lamp.run(0.1)
    light = lamp.power_off()
    assert light.tones() == [2000, 3000, 4000, 2000]
    assert (np.diff(light.ticks[2:]) == 2000).sum() == pytest.approx(20, abs=1)


def test_upload_that_rests_gives_way_to_the_kept_frame(firmware: Path, eeprom: Path) -> None:
    lamp = SimulatedLamp(firmware, eeprom)
    lamp.load(TONE)
    lamp.load(bytes_of_frame(replace(constant_tone_frame(4000.0), plays=200)), keep=False)
    requests = upload_requests(TONE, keep=False)
    lamp.ask(requests[0])
    lamp.run(0.1)
    assert lamp.ask('s').startswith('playing kept')
    assert lamp.ask(requests[1]) == 'ERR begin'
    lamp.power_off()


def test_frame_that_waits_is_told_apart_from_the_one_that_plays(firmware: Path, eeprom: Path) -> None:
    slow, next_one = (bytes_of_frame(ufsook_frame([packet])) for packet in (ID, bytes(20)))
    lamp = SimulatedLamp(firmware, eeprom)
    lamp.load(slow)
    lamp.load(next_one, keep=False)
    assert lamp.ask('s') == f'playing kept {len(slow)} {slow[-2:].hex()} 1'
    lamp.run(1.0)
    assert lamp.ask('s') == f'playing temporary {len(next_one)} {next_one[-2:].hex()} 0'
    lamp.load(slow)
    assert lamp.ask('s').startswith('playing temporary')
    assert lamp.ask('b 40') == 'ERR busy'
    assert lamp.ask('h') == 'OK'
    assert lamp.ask('s') == f'steady kept {len(slow)} {slow[-2:].hex()} 0'
    assert lamp.ask('b 40') == 'OK'
    assert lamp.ask('p') == 'OK'
    lamp.run(1.0)
    assert lamp.ask('s').startswith('playing kept')
    lamp.power_off()


def test_commands_are_streamed_with_a_rising_counter(firmware: Path, eeprom: Path) -> None:
    commands = [CommandPacket(Command(3, 5, 1.570796, 100 + i, is_one_shot=True), b'abcd') for i in range(3)]
    lamp = SimulatedLamp(firmware, eeprom)
    lamp.load(bytes_of_frame(ufsook_frame([ID])))
    for command in commands:
        while lamp.ask('s').endswith(' 1'):
            lamp.run(0.2)
        assert (
            lamp.load(bytes_of_frame(ufsook_frame([command.to_bytes(), ID], plays=2)), keep=False)[-1] == 'OK'
        )
        refused = lamp.ask('b 40')
        assert refused == 'ERR busy'
        lamp.run(8.0)
    lamp.run(30.0)
    light = lamp.power_off()
    assert np.diff(light.ticks[2:]).max() < 0.005 * TICK_RATE
    seconds = int(light.ticks[-1] / TICK_RATE)
    whole = light.waveform(light.first_dark(), seconds * TICK_RATE - light.first_dark(), 1)
    stamps = np.arange(0.0, whole.period - 0.1, 1.0 / 60.0)
    got = [
        received.packet for received in UfsookDecoder().add_frames(stamps, whole.exposed(stamps, 5e-4), 5e-4)
    ]
    heard = [packet for packet in got if packet != IdPacket(4711)]
    assert list(dict.fromkeys(heard)) == commands
    assert heard == sorted(heard, key=lambda packet: packet.command.counter)
    assert got[-1] == IdPacket(4711)


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
    'a short step': (edited(12, 0, 0, 0x1F, 0x03), 'trains'),
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
    assert lamp.ask('s') == f'playing kept {len(TONE)} {TONE[-2:].hex()} 0'
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
    frame = np.frombuffer(bytes_of_frame(ufsook_frame([ID])), np.uint8)
    for _ in range(20):
        damage = np.packbits(rng.random(8 * len(frame)) < rng.choice([0.003, 0.03, 0.5]))
        if damage.any():
            assert lamp.load((frame ^ damage).tobytes())[-1].startswith('ERR')


def test_frame_too_long_is_refused(lamp: SimulatedLamp) -> None:
    assert lamp.ask(f'b {LENGTH_MAX + 1}') == 'ERR length'
    assert lamp.ask('b 0') == 'ERR length'
    assert lamp.ask('b 4') == 'OK'
    assert lamp.ask('d 0 0102030405') == 'ERR length'


def test_bad_lines_are_refused(lamp: SimulatedLamp) -> None:
    assert lamp.ask('x') == 'ERR command'
    assert lamp.ask('d' * 200) == 'ERR line'
    assert lamp.ask('v') == f'led_beacon 1 {LENGTH_MAX}'
    assert lamp.ask('b 8') == 'OK'
    assert lamp.ask('d 1 00') == 'ERR offset'
    assert lamp.ask('d 0') == 'ERR offset'
    assert lamp.ask('d 0 0g') == 'ERR hex'
    assert lamp.ask('d 0 012') == 'ERR hex'
    assert lamp.ask('d 0 0102') == 'OK'
    assert lamp.ask('d 0 0102') == 'OK'
    assert lamp.ask('k') == 'ERR length'
    assert lamp.ask('k') == 'ERR begin'
    assert lamp.ask('d 0 00') == 'ERR begin'


def test_lamp_and_host_refuse_the_same_frames(firmware: Path, eeprom: Path) -> None:
    rng = np.random.default_rng(6)
    body = bytes_of_frame(ufsook_frame([ID]))[:-2]
    lamp = SimulatedLamp(firmware, eeprom)
    answers = []
    for _ in range(150):
        changed = bytearray(body)
        changed[rng.integers(44)] = rng.choice([0, 1, 2, 3, 4, 64, 255])
        frame = with_crc(bytes(changed))
        try:
            frame_of_bytes(frame)
            expected = 'OK'
        except LampFrameError:
            expected = 'ERR'
        # What is accepted goes out of the way of the next one.
        lamp.ask('h')
        answers.append(lamp.load(frame, keep=False)[-1].split()[0])
        assert answers[-1] == expected, frame.hex()
    lamp.power_off()
    assert min(answers.count('OK'), answers.count('ERR')) > 30


def test_host_speaks_with_the_lamp(firmware: Path, eeprom: Path) -> None:
    frame = bytes_of_frame(ufsook_frame([ID]))
    streamed = [bytes_of_frame(constant_tone_frame(tone)) for tone in (3000.0, 4000.0)]
    lamp = SimulatedLamp(firmware, eeprom)
    with terminal_of(lamp) as path, LampPort(path) as port:
        assert port.status() == LampStatus(False, 'none', 0, 0, False)
        port.load(frame, keep=True)
        assert port.status() == LampStatus(True, 'kept', len(frame), int.from_bytes(frame[-2:]), False)
        port.load(TONE, keep=True)
        port.stream(streamed)
        port.shine_steadily()
        assert not port.status().is_playing
        port.play()
        with pytest.raises(VlcBeaconError, match="answers 'ERR crc' to 'k'"):
            port.load(frame[:-1], keep=True)
    assert [tone for tone in lamp.power_off().tones() if tone >= 2000] == [2000, 3000, 4000]


@contextmanager
def terminal_of(lamp: SimulatedLamp) -> Iterator[Path]:
    """Connect a lamp to a pseudo-terminal."""
    master, slave = pty.openpty()
    over = threading.Event()

    def serve() -> None:
        while not over.is_set():
            if select.select([master], [], [], 0.001)[0]:
                lamp.send(os.read(master, 256))
            os.write(master, lamp.run(0.02))

    thread = threading.Thread(target=serve)
    thread.start()
    try:
        yield Path(os.ttyname(slave))
    finally:
        over.set()
        thread.join()
        os.close(master)
        os.close(slave)
