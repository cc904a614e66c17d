"""Serial commands of the LED beacon firmware."""

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from simulated_lamp import TICK_RATE, SimulatedLamp
from simulated_terminal import terminal_of

from vlc_beacon.commands.lamp_port import LampPort, upload_requests
from vlc_beacon.core.light_code.ufsook import UfsookDecoder
from vlc_beacon.core.packet.command_packet import Command, CommandPacket
from vlc_beacon.core.packet.id_packet import IdPacket
from vlc_beacon.core.transmitter.lamp_frame import LampFrame, Section, frame_to_bytes
from vlc_beacon.core.transmitter.lamp_program import constant_tone_frame, ufsook_frame
from vlc_beacon.core.vlc_beacon_error import VlcBeaconError

pytestmark = pytest.mark.newest_set_only

ID = IdPacket(4711).to_bytes()
TONE = frame_to_bytes(constant_tone_frame(2000.0))


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
    ten_times = frame_to_bytes(replace(constant_tone_frame(4000.0), plays=10))
    assert lamp.load(ten_times, keep=False)[-1] == 'OK'
    lamp.run(0.1)
    assert lamp.ask('s').startswith('playing kept')
    light = lamp.power_off()
    assert light.tones() == [2000, 4000, 2000]
    assert (np.diff(light.ticks[2:]) == 2000).sum() >= 2 * 10 - 1

    lamp = SimulatedLamp(firmware, eeprom)
    lamp.load(frame_to_bytes(constant_tone_frame(4000.0)), keep=False)
    assert lamp.ask('s').startswith('playing temporary')
    lamp.power_off()
    lamp = SimulatedLamp(firmware, eeprom)
    assert lamp.ask('s') == f'playing kept {len(TONE)} {TONE[-2:].hex()} 0'
    lamp.power_off()


def test_temporary_frame_is_played_to_its_end(firmware: Path, eeprom: Path) -> None:
    tones = [constant_tone_frame(tone) for tone in (3000.0, 4000.0)]
    both = LampFrame(
        pattern=tones[0].pattern,
        bits=1,
        pulse_trains=tuple(replace(tone.pulse_trains[0], steps=20) for tone in tones),
        preamble=(),
        sections=[Section(np.array([[0]])), Section(np.array([[1]]))],
        plays=1,
    )
    lamp = SimulatedLamp(firmware, eeprom)
    lamp.load(TONE)
    lamp.load(frame_to_bytes(both), keep=False)
    lamp.run(0.1)
    light = lamp.power_off()
    assert light.tones() == [2000, 3000, 4000, 2000]
    assert (np.diff(light.ticks[2:]) == 2000).sum() == pytest.approx(20, abs=1)


def test_upload_that_rests_gives_way_to_the_kept_frame(firmware: Path, eeprom: Path) -> None:
    lamp = SimulatedLamp(firmware, eeprom)
    lamp.load(TONE)
    lamp.load(frame_to_bytes(replace(constant_tone_frame(4000.0), plays=200)), keep=False)
    requests = upload_requests(TONE, keep=False)
    lamp.ask(requests[0])
    lamp.run(0.1)
    assert lamp.ask('s').startswith('playing kept')
    assert lamp.ask(requests[1]) == 'ERR begin'
    lamp.power_off()


def test_the_pending_frame_differs_from_the_transmitted_one(firmware: Path, eeprom: Path) -> None:
    slow, next_one = (frame_to_bytes(ufsook_frame([packet])) for packet in (ID, bytes(20)))
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
    lamp.load(frame_to_bytes(ufsook_frame([ID])))
    for command in commands:
        while lamp.ask('s').endswith(' 1'):
            lamp.run(0.2)
        assert (
            lamp.load(frame_to_bytes(ufsook_frame([command.to_bytes(), ID], plays=2)), keep=False)[-1] == 'OK'
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
        received.packet
        for received in UfsookDecoder().add_frames(stamps, whole.exposure_means(stamps, 5e-4), 5e-4)
    ]
    heard = [packet for packet in got if packet != IdPacket(4711)]
    assert list(dict.fromkeys(heard)) == commands
    assert heard == sorted(heard, key=lambda packet: packet.command.counter)
    assert got[-1] == IdPacket(4711)


def test_host_communicates_with_the_lamp(firmware: Path, eeprom: Path) -> None:
    lamp, temporary = SimulatedLamp(firmware, eeprom), frame_to_bytes(constant_tone_frame(3000.0))
    with terminal_of(lamp) as path, LampPort(path) as port:
        port.load(TONE, keep=True)
        port.load(temporary, keep=False)
        with pytest.raises(VlcBeaconError, match="replied 'ERR crc' to 'k'"):
            port.load(frame_to_bytes(ufsook_frame([ID]))[:-1], keep=True)
    assert [tone for tone in lamp.power_off().tones() if tone >= 2000] == [2000, 3000]
