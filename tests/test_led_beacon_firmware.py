"""The lamp's firmware in a simulated ATmega328P: its light, read by the receivers, and what it refuses."""

import os
from collections.abc import Iterator
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from light_channel import seen_by_global_shutter, seen_by_rolling_shutter
from simulated_lamp import TICK_RATE, Light, SimulatedLamp, build_firmware, missing_tools

from vlc_beacon.core.light_code.manchester import SlotFormat, slots_waveform
from vlc_beacon.core.light_code.manchester_decoder import ManchesterDecoder
from vlc_beacon.core.light_code.reed_solomon_block import slots_of_packet
from vlc_beacon.core.light_code.rs_fsk import constant_tone_waveform, rs_fsk_waveform
from vlc_beacon.core.light_code.rs_fsk_decoder import RsFskDecoder
from vlc_beacon.core.light_code.ufsook import ufsook_waveform
from vlc_beacon.core.light_code.ufsook_decoder import UfsookDecoder
from vlc_beacon.core.light_code.waveform import Waveform
from vlc_beacon.core.packet.command_packet import Command, CommandPacket
from vlc_beacon.core.packet.crc import crc16
from vlc_beacon.core.packet.data_packet import DataPacket
from vlc_beacon.core.packet.id_packet import IdPacket
from vlc_beacon.core.packet.packet_reader import Packet
from vlc_beacon.core.transmitter.coded_frame import (
    constant_tone_frame,
    manchester_frame,
    rs_fsk_frame,
    ufsook_frame,
)
from vlc_beacon.core.transmitter.lamp_frame import STEP_FRACTION, STEP_TICKS_MIN, LampFrame, Train
from vlc_beacon.core.transmitter.lamp_frame_bytes import LENGTH_MAX, bytes_of_frame
from vlc_beacon.core.transmitter.lamp_frame_waveform import waveform_of_frame
from vlc_beacon.core.transmitter.serial_protocol import upload_requests

ID = IdPacket(4711)
COMMAND = CommandPacket(Command(3, 5, -1.570796, 77), b'abcd')
TEXT = DataPacket('曲がる'.encode(), is_text=True)
HUNDRED = DataPacket(np.random.default_rng(0).bytes(100))
SLOTS = SlotFormat(1)
TONE = bytes_of_frame(constant_tone_frame(2000.0))
OTHER_TONE = bytes_of_frame(constant_tone_frame(4000.0))
LATENESS = 3
"""The simulator looks at its timers between instructions [ticks]."""


@pytest.fixture(scope='module')
def build(tmp_path_factory: pytest.TempPathFactory) -> Path:
    missing = missing_tools()
    if missing and os.environ.get('CI') != 'true':
        pytest.skip(
            f'{", ".join(missing)} missing: apt-get install make gcc libc6-dev gcc-avr avr-libc libsimavr-dev'
        )
    folder = tmp_path_factory.mktemp('firmware')
    build_firmware(folder)
    return folder


@pytest.fixture
def eeprom(tmp_path: Path) -> Path:
    return tmp_path / 'eeprom.bin'


def bytes_of(*packets: Packet) -> list[bytes]:
    return [packet.to_bytes() for packet in packets]


def slots_of(packets: list[bytes]) -> Waveform:
    return slots_waveform(
        [slot for packet in packets for slot in slots_of_packet(packet, SLOTS.slot_bytes)], SLOTS
    )


def light_of(build: Path, eeprom: Path, frame: LampFrame, periods: int = 1) -> Light:
    """Return how a lamp shines that is given a frame."""
    lamp = SimulatedLamp(build, eeprom)
    assert set(lamp.load(bytes_of_frame(frame))) == {'OK'}
    lamp.run(periods * waveform_of_frame(frame).period + 0.01)
    return lamp.power_off()


def played(light: Light, frame: LampFrame, periods: int) -> Waveform:
    """Return whole periods of a light that began with a frame."""
    expected = waveform_of_frame(frame)
    start = light.first_dark() - round(float(expected.times[1]) * TICK_RATE)
    return light.waveform(start, expected.period * TICK_RATE, periods)


def switches(waveform: Waveform, periods: int) -> tuple[np.ndarray, np.ndarray]:
    """Return when and to what a waveform changes, from its first change on [ticks]."""
    levels = np.resize(waveform.levels, (len(waveform.levels), 2)) if waveform.levels.shape[1] == 2 else None
    both = levels if levels is not None else np.repeat(waveform.levels, 2, axis=1)
    times = np.concatenate([waveform.times + i * waveform.period for i in range(periods)]) * TICK_RATE
    states = np.tile(both @ [1, 2], periods).astype(int)
    changes = np.flatnonzero(states[1:] != states[:-1]) + 1
    return times[changes] - times[changes[0]], states[changes]


CODES = {
    'ufsook': (ufsook_frame(bytes_of(ID, TEXT)), ufsook_waveform(bytes_of(ID, TEXT)), 2),
    'rs_fsk': (rs_fsk_frame(bytes_of(ID, TEXT), 30.0), rs_fsk_waveform(bytes_of(ID, TEXT), 30.0), 2),
    'manchester': (manchester_frame(bytes_of(ID, HUNDRED), SLOTS), slots_of(bytes_of(ID, HUNDRED)), 1),
    'tone': (constant_tone_frame(3333.0), constant_tone_waveform(3333.0), 100),
}


@pytest.mark.parametrize('code', CODES)
def test_light_is_the_codes_waveform_within_a_tick(build: Path, eeprom: Path, code: str) -> None:
    frame, waveform, periods = CODES[code]
    light = light_of(build, eeprom, frame, periods)
    times, states = switches(waveform, periods)
    first = np.flatnonzero(light.ticks == light.first_dark())[0]
    seen = slice(first, first + len(times))
    assert light.states[seen].tolist() == states.tolist()
    late = light.ticks[seen] - light.first_dark() - times
    assert np.abs(late - (late.max() + late.min()) / 2.0).max() <= 1.0


def test_nothing_on_the_line_moves_the_light(build: Path, eeprom: Path) -> None:
    """Steps as short as they may be, the longest way to the next symbol, and a line that never rests."""
    step = STEP_TICKS_MIN * STEP_FRACTION
    tone = constant_tone_frame(4000.0)
    frame = replace(tone, trains=(Train(0, 1, step), Train(1, 1, step)), bits=1)
    frame = replace(frame, sections=[replace(tone.sections[0], symbols=np.array([[0], [1]]))] * 3)
    lamp = SimulatedLamp(build, eeprom)
    lamp.load(bytes_of_frame(frame))
    lamp.send(b's\rv\rd 0 00\r' * 200)
    lamp.run(0.2)
    lamp.load(bytes_of_frame(frame), keep=True)
    light = lamp.power_off()
    intervals = np.diff(light.ticks[2:])
    assert len(intervals) > 4000
    assert np.abs(intervals - STEP_TICKS_MIN).max() <= LATENESS
    assert light.preparation < 0.9 * STEP_TICKS_MIN


def test_global_shutter_reads_the_light(build: Path, eeprom: Path) -> None:
    frame = ufsook_frame(bytes_of(ID, COMMAND, TEXT))
    light = played(light_of(build, eeprom, frame, 2), frame, 2)
    seen = seen_by_global_shutter(light, 40.0, np.random.default_rng(1))
    got = [received.packet for received in UfsookDecoder().add_frames(*seen, 5e-4)]
    assert set(got) == {ID, COMMAND, TEXT}


def test_rolling_shutter_reads_tones(build: Path, eeprom: Path) -> None:
    frame = rs_fsk_frame(bytes_of(ID, COMMAND, TEXT), 30.0)
    light = played(light_of(build, eeprom, frame), frame, 1)
    seen = seen_by_rolling_shutter(light, 40.0, np.random.default_rng(2))
    got = [received.packet for received in RsFskDecoder(30.0).add_frames(seen)]
    assert set(got) == {ID, COMMAND, TEXT}


def test_rolling_shutter_reads_a_hundred_bytes_in_chips(build: Path, eeprom: Path) -> None:
    frame = manchester_frame(bytes_of(ID, HUNDRED), SLOTS)
    light = played(light_of(build, eeprom, frame), frame, 1)
    seen = seen_by_rolling_shutter(light, 20.0, np.random.default_rng(3), rows=304)
    got = [received.packet for received in ManchesterDecoder(SLOTS).add_frames(seen)]
    assert set(got) == {ID, HUNDRED}


def test_kept_frame_is_played_after_power_up(build: Path, eeprom: Path) -> None:
    frame = CODES['rs_fsk'][0]
    before = light_of(build, eeprom, frame)
    lamp = SimulatedLamp(build, eeprom)
    lamp.run(waveform_of_frame(frame).period + 0.01)
    after = lamp.power_off()
    count = min(len(before.ticks), len(after.ticks))
    steps = [np.diff(light.ticks[2:count]) for light in (before, after)]
    assert np.abs(steps[0] - steps[1]).max() <= 2 * LATENESS
    assert before.ticks[2] > after.ticks[2]


def test_new_lamp_shines_steadily(build: Path, eeprom: Path) -> None:
    lamp = SimulatedLamp(build, eeprom)
    assert lamp.ask('s') == 'steady none 0 0000 0'
    assert lamp.ask('p') == 'ERR none'
    lamp.run(0.1)
    assert lamp.power_off().states.tolist() == [0, 3]


def test_lamp_stops_and_plays_again(build: Path, eeprom: Path) -> None:
    lamp = SimulatedLamp(build, eeprom)
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


def tones_of(light: Light) -> list[int]:
    """Return the tones that were played one after the other [Hz], pauses left out."""
    steps = np.diff(light.ticks[2:])
    tones = np.round(0.5 * TICK_RATE / steps[steps < 20_000], -2).astype(int)
    return [int(tone) for i, tone in enumerate(tones) if i == 0 or tone != tones[i - 1]]


def test_temporary_frame_gives_way_to_the_kept_one(build: Path, eeprom: Path) -> None:
    lamp = SimulatedLamp(build, eeprom)
    lamp.load(TONE)
    ten_times = bytes_of_frame(replace(constant_tone_frame(4000.0), plays=10))
    assert lamp.load(ten_times, keep=False)[-1] == 'OK'
    lamp.run(0.1)
    assert lamp.ask('s').startswith('playing kept')
    light = lamp.power_off()
    assert tones_of(light) == [2000, 4000, 2000]
    assert (np.diff(light.ticks[2:]) == 2000).sum() >= 2 * 10 - 1

    lamp = SimulatedLamp(build, eeprom)
    lamp.load(OTHER_TONE, keep=False)
    assert lamp.ask('s').startswith('playing temporary')
    lamp.power_off()
    lamp = SimulatedLamp(build, eeprom)
    assert lamp.ask('s') == f'playing kept {len(TONE)} {TONE[-2:].hex()} 0'
    lamp.power_off()


def test_upload_that_rests_gives_way_to_the_kept_frame(build: Path, eeprom: Path) -> None:
    lamp = SimulatedLamp(build, eeprom)
    lamp.load(TONE)
    lamp.load(bytes_of_frame(replace(constant_tone_frame(4000.0), plays=1)), keep=False)
    requests = upload_requests(OTHER_TONE, keep=False)
    lamp.ask(requests[0])
    lamp.run(0.1)
    assert lamp.ask('s').startswith('playing kept')
    assert lamp.ask(requests[1]) == 'ERR begin'
    lamp.power_off()


def test_commands_are_streamed_with_a_rising_counter(build: Path, eeprom: Path) -> None:
    commands = [CommandPacket(Command(3, 5, 1.570796, 100 + i, is_one_shot=True), b'abcd') for i in range(3)]
    lamp = SimulatedLamp(build, eeprom)
    lamp.load(bytes_of_frame(ufsook_frame(bytes_of(ID))))
    for command in commands:
        while lamp.ask('s').endswith(' 1'):
            lamp.run(0.2)
        assert lamp.load(bytes_of_frame(ufsook_frame(bytes_of(command, ID), plays=2)), keep=False)[-1] == 'OK'
        refused = lamp.ask('b 40')
        assert refused == 'ERR busy'
        lamp.run(8.0)
    lamp.run(30.0)
    light = lamp.power_off()
    assert np.diff(light.ticks[2:]).max() < 0.005 * TICK_RATE
    seconds = int(light.ticks[-1] / TICK_RATE)
    whole = light.waveform(light.first_dark(), seconds * TICK_RATE - light.first_dark(), 1)
    stamps = np.arange(0.0, whole.period - 0.1, 1.0 / 60.0)
    got = [received.packet for received in UfsookDecoder().add_frames(stamps, whole.exposed(stamps, 5e-4), 5e-4)]
    heard = [packet for packet in got if packet != ID]
    assert list(dict.fromkeys(heard)) == commands
    assert heard == sorted(heard, key=lambda packet: packet.command.counter)
    assert got[-1] == ID


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
def lamp(build: Path, tmp_path_factory: pytest.TempPathFactory) -> Iterator[SimulatedLamp]:
    """A lamp that plays a tone and goes on doing so whatever happens."""
    lamp = SimulatedLamp(build, tmp_path_factory.mktemp('lamp') / 'eeprom.bin')
    lamp.load(TONE)
    lamp.run(0.01)
    yield lamp
    lamp.run(0.01)
    assert lamp.ask('s') == f'playing kept {len(TONE)} {TONE[-2:].hex()} 0'
    assert tones_of(lamp.power_off()) == [2000]


@pytest.mark.parametrize('fault', REFUSED)
def test_bad_frame_is_refused_with_a_reason(lamp: SimulatedLamp, fault: str) -> None:
    frame, reason = REFUSED[fault]
    for keep in (False, True):
        *others, last = lamp.load(frame, keep=keep)
        assert set(others) == {'OK'}
        assert last == f'ERR {reason}'


def test_damaged_frames_are_refused(lamp: SimulatedLamp) -> None:
    rng = np.random.default_rng(4)
    frame = np.frombuffer(bytes_of_frame(ufsook_frame(bytes_of(ID))), np.uint8)
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


def test_longest_frame_is_played(build: Path, eeprom: Path) -> None:
    packets = [*bytes_of(*[HUNDRED] * 4), DataPacket(bytes(11)).to_bytes()]
    frame = ufsook_frame(packets)
    data = bytes_of_frame(frame)
    assert len(data) == LENGTH_MAX
    lamp = SimulatedLamp(build, eeprom)
    assert set(lamp.load(data)) == {'OK'}
    lamp.run(1.0)
    lamp.power_off()
    lamp = SimulatedLamp(build, eeprom)
    assert lamp.ask('s') == f'playing kept {LENGTH_MAX} {data[-2:].hex()} 0'
    lamp.power_off()


def crc_played(build: Path, eeprom: Path) -> str:
    """Return the checksum of the kept frame that is played after power up."""
    lamp = SimulatedLamp(build, eeprom)
    state, source, _, crc, _ = lamp.ask('s').split()
    lamp.power_off()
    assert (state, source) == ('playing', 'kept')
    return crc


def test_power_cut_while_writing_keeps_one_whole_frame(build: Path, eeprom: Path) -> None:
    """Whenever it comes, also within a byte, which then is anything."""
    rng = np.random.default_rng(5)
    old, new = TONE, bytes_of_frame(ufsook_frame(bytes_of(ID)))
    lamp = SimulatedLamp(build, eeprom)
    lamp.load(bytes_of_frame(constant_tone_frame(3000.0)))
    lamp.load(old)
    lamp.power_off()
    contents = [eeprom.read_bytes()]
    found = [crc_played(build, eeprom)]
    for count in range(1, 60):
        eeprom.write_bytes(contents[0])
        lamp = SimulatedLamp(build, eeprom)
        for request in upload_requests(new, keep=True)[:-1]:
            lamp.ask(request)
        lamp.send(b'k\r')
        lamp.write_eeprom(count)
        lamp.power_off()
        contents.append(eeprom.read_bytes())
        found.append(crc_played(build, eeprom))
        for at in [i for i in range(1024) if contents[-1][i] != contents[-2][i]]:
            torn = contents[-2][:at] + rng.bytes(1) + contents[-2][at + 1 :]
            eeprom.write_bytes(torn)
            assert crc_played(build, eeprom) in (old[-2:].hex(), new[-2:].hex())
    assert len(set(contents)) > 30
    assert list(dict.fromkeys(found)) == [old[-2:].hex(), new[-2:].hex()]


def test_worn_or_strange_eeprom_leaves_the_lamp_shining(build: Path, eeprom: Path) -> None:
    for seed in range(5):
        eeprom.write_bytes(np.random.default_rng(seed).bytes(1024))
        lamp = SimulatedLamp(build, eeprom)
        assert lamp.ask('s') == 'steady none 0 0000 0'
        assert set(lamp.load(TONE)) == {'OK'}
        lamp.power_off()
