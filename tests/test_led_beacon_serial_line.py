"""Serial commands of the LED beacon firmware, and what it keeps in EEPROM, also when power fails during a write."""

from collections.abc import Callable
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from lamp_frame_reading import waveform_from_frame
from simulated_lamp import TICK_RATE, TONE, SimulatedLamp, status_of, tone_bytes
from simulated_terminal import terminal_of

from vlc_beacon.commands.encode import LampPort, upload_requests
from vlc_beacon.core.light_code.ufsook import UfsookDecoder
from vlc_beacon.core.packet.command_packet import Command, CommandPacket
from vlc_beacon.core.packet.data_packet import DataPacket, IdPacket
from vlc_beacon.core.transmitter.lamp_frame import LENGTH_MAX, LampFrame, Section, frame_to_bytes
from vlc_beacon.core.transmitter.lamp_program import constant_tone_frame, rs_fsk_frame, ufsook_frame
from vlc_beacon.core.vlc_beacon_error import VlcBeaconError

pytestmark = pytest.mark.newest_set_only

ID = IdPacket(4711).to_bytes()
PowerUp = Callable[[], SimulatedLamp]


def test_new_lamp_shines_steadily(lamp: SimulatedLamp) -> None:
    assert lamp.ask('s') == 'steady none 0 0000 0'
    assert lamp.ask('p') == 'ERR none'
    lamp.run(0.1)
    assert lamp.power_off().states.tolist() == [0, 3]


def test_lamp_stops_and_plays_again(lamp: SimulatedLamp) -> None:
    lamp.load(TONE)
    lamp.run(0.1)
    assert lamp.ask('h') == 'OK'
    assert lamp.ask('s') == status_of(TONE, 'steady kept')
    lamp.run(0.5)
    assert lamp.ask('p') == 'OK'
    lamp.run(0.1)
    light = lamp.power_off()
    pauses = np.flatnonzero(np.diff(light.ticks) > TICK_RATE // 2)
    assert [int(light.states[i]) for i in pauses] == [3]
    assert len(light.ticks) > 700


def test_temporary_frame_gives_way_to_the_kept_one(power_up: PowerUp) -> None:
    lamp = power_up()
    lamp.load(TONE)
    assert lamp.load(tone_bytes(4000.0, plays=10), keep=False)[-1] == 'OK'
    lamp.run(0.1)
    assert lamp.ask('s').startswith('playing kept')
    light = lamp.power_off()
    assert light.tones() == [2000, 4000, 2000]
    assert (np.diff(light.ticks[2:]) == 2000).sum() >= 2 * 10 - 1
    lamp = power_up()
    lamp.load(tone_bytes(4000.0), keep=False)
    assert lamp.ask('s').startswith('playing temporary')
    assert power_up().ask('s') == status_of(TONE)


def test_temporary_frame_is_played_to_its_end(lamp: SimulatedLamp) -> None:
    tones = [constant_tone_frame(tone) for tone in (3000.0, 4000.0)]
    trains = tuple(replace(tone.pulse_trains[0], steps=20) for tone in tones)
    sections = [Section(np.array([[0]])), Section(np.array([[1]]))]
    both = LampFrame(tones[0].pattern, 1, trains, (), sections, plays=1)
    lamp.load(TONE)
    lamp.load(frame_to_bytes(both), keep=False)
    lamp.run(0.1)
    light = lamp.power_off()
    assert light.tones() == [2000, 3000, 4000, 2000]
    assert (np.diff(light.ticks[2:]) == 2000).sum() == pytest.approx(20, abs=1)


def test_upload_that_rests_gives_way_to_the_kept_frame(lamp: SimulatedLamp) -> None:
    lamp.load(TONE)
    lamp.load(tone_bytes(4000.0, plays=200), keep=False)
    requests = upload_requests(TONE, keep=False)
    lamp.ask(requests[0])
    lamp.run(0.1)
    assert lamp.ask('s').startswith('playing kept')
    assert lamp.ask(requests[1]) == 'ERR begin'


def test_the_pending_frame_differs_from_the_transmitted_one(lamp: SimulatedLamp) -> None:
    slow, next_one = (frame_to_bytes(ufsook_frame([packet])) for packet in (ID, bytes(20)))
    lamp.load(slow)
    lamp.load(next_one, keep=False)
    assert lamp.ask('s') == status_of(slow, pending=1)
    lamp.run(1.0)
    assert lamp.ask('s') == status_of(next_one, 'playing temporary')
    lamp.load(slow)
    assert lamp.ask('s').startswith('playing temporary')
    assert [lamp.ask(request) for request in ('b 40', 'h')] == ['ERR busy', 'OK']
    assert lamp.ask('s') == status_of(slow, 'steady kept')
    assert [lamp.ask(request) for request in ('b 40', 'p')] == ['OK', 'OK']
    lamp.run(1.0)
    assert lamp.ask('s').startswith('playing kept')


def test_commands_are_streamed_with_a_rising_counter(lamp: SimulatedLamp) -> None:
    commands = [CommandPacket(Command(3, 5, 1.570796, 100 + i, is_one_shot=True), b'abcd') for i in range(3)]
    lamp.load(frame_to_bytes(ufsook_frame([ID])))
    for command in commands:
        while lamp.ask('s').endswith(' 1'):
            lamp.run(0.2)
        frame = ufsook_frame([command.to_bytes(), ID], plays=2)
        assert lamp.load(frame_to_bytes(frame), keep=False)[-1] == 'OK'
        assert lamp.ask('b 40') == 'ERR busy'
        lamp.run(8.0)
    lamp.run(30.0)
    light = lamp.power_off()
    assert np.diff(light.ticks[2:]).max() < 0.005 * TICK_RATE
    seconds = int(light.ticks[-1] / TICK_RATE)
    whole = light.waveform(light.first_dark(), seconds * TICK_RATE - light.first_dark(), 1)
    stamps = np.arange(0.0, whole.period - 0.1, 1.0 / 60.0)
    seen = whole.exposure_means(stamps, 5e-4)
    got = [received.packet for received in UfsookDecoder().add_frames(stamps, seen, 5e-4)]
    heard = [packet for packet in got if packet != IdPacket(4711)]
    assert list(dict.fromkeys(heard)) == commands
    assert heard == sorted(heard, key=lambda packet: packet.command.counter)
    assert got[-1] == IdPacket(4711)


def test_host_communicates_with_the_lamp(lamp: SimulatedLamp) -> None:
    with terminal_of(lamp) as path, LampPort(path) as port:
        port.load(TONE, keep=True)
        port.load(tone_bytes(3000.0), keep=False)
        with pytest.raises(VlcBeaconError, match="replied 'ERR crc' to 'k'"):
            port.load(frame_to_bytes(ufsook_frame([ID]))[:-1], keep=True)
    assert [tone for tone in lamp.power_off().tones() if tone >= 2000] == [2000, 3000]


def test_kept_frame_is_played_after_power_up(power_up: PowerUp) -> None:
    frame = rs_fsk_frame([ID], 30.0)
    lights = []
    for is_new in (True, False):
        lamp = power_up()
        if is_new:
            lamp.load(frame_to_bytes(frame))
        lamp.run(waveform_from_frame(frame).period)
        lights.append(lamp.power_off())
    count = min(len(light.ticks) for light in lights)
    steps = [np.diff(light.ticks[2:count]) for light in lights]
    assert np.abs(steps[0] - steps[1]).max() <= 1
    assert lights[0].ticks[2] > lights[1].ticks[2]


def test_longest_frame_is_played(power_up: PowerUp) -> None:
    payloads = [bytes(100)] * 4 + [bytes(11)]
    data = frame_to_bytes(ufsook_frame([DataPacket(payload).to_bytes() for payload in payloads]))
    assert len(data) == LENGTH_MAX
    lamp = power_up()
    assert set(lamp.load(data)) == {'OK'}
    lamp.run(1.0)
    assert power_up().ask('s') == status_of(data)


def status_after(power_up: PowerUp) -> str:
    """Return the status of a lamp that is switched on and off."""
    lamp = power_up()
    status = lamp.ask('s')
    lamp.power_off()
    return status


def test_power_cut_while_writing_keeps_one_whole_frame(power_up: PowerUp, eeprom: Path) -> None:
    """Whenever it comes, also within a byte, which then is anything."""
    rng = np.random.default_rng(5)
    old, new = TONE, frame_to_bytes(ufsook_frame([ID]))
    whole = [status_of(frame) for frame in (old, new)]
    lamp = power_up()
    lamp.load(tone_bytes(3000.0))
    lamp.load(old)
    lamp.power_off()
    contents = [eeprom.read_bytes()]
    found = [status_after(power_up)]
    for count in range(1, 60):
        eeprom.write_bytes(contents[0])
        lamp = power_up()
        for request in upload_requests(new, keep=True)[:-1]:
            lamp.ask(request)
        lamp.send(b'k\r')
        lamp.write_eeprom(count)
        lamp.power_off()
        contents.append(eeprom.read_bytes())
        found.append(status_after(power_up))
        for at in [i for i in range(1024) if contents[-1][i] != contents[-2][i]]:
            eeprom.write_bytes(contents[-2][:at] + rng.bytes(1) + contents[-2][at + 1 :])
            assert status_after(power_up) in whole
    assert len(set(contents)) > 30
    assert list(dict.fromkeys(found)) == whole


def test_worn_or_strange_eeprom_leaves_the_lamp_shining(power_up: PowerUp, eeprom: Path) -> None:
    for seed in range(5):
        eeprom.write_bytes(np.random.default_rng(seed).bytes(1024))
        lamp = power_up()
        assert lamp.ask('s') == 'steady none 0 0000 0'
        assert set(lamp.load(TONE)) == {'OK'}
        lamp.power_off()
