"""What the LED beacon firmware stores in EEPROM, also when power fails during a write."""

from pathlib import Path

import numpy as np
import pytest
from lamp_frame_reading import waveform_from_frame
from simulated_lamp import SimulatedLamp

from vlc_beacon.commands.lamp_port import upload_requests
from vlc_beacon.core.packet.data_packet import DataPacket
from vlc_beacon.core.packet.id_packet import IdPacket
from vlc_beacon.core.transmitter.lamp_frame import LENGTH_MAX, frame_to_bytes
from vlc_beacon.core.transmitter.lamp_program import constant_tone_frame, rs_fsk_frame, ufsook_frame

pytestmark = pytest.mark.newest_set_only

ID = IdPacket(4711).to_bytes()
TONE = frame_to_bytes(constant_tone_frame(2000.0))


def test_kept_frame_is_played_after_power_up(firmware: Path, eeprom: Path) -> None:
    frame = rs_fsk_frame([ID], 30.0)
    lamp = SimulatedLamp(firmware, eeprom)
    lamp.load(frame_to_bytes(frame))
    lamp.run(waveform_from_frame(frame).period)
    before = lamp.power_off()
    lamp = SimulatedLamp(firmware, eeprom)
    lamp.run(waveform_from_frame(frame).period)
    after = lamp.power_off()
    count = min(len(before.ticks), len(after.ticks))
    steps = [np.diff(light.ticks[2:count]) for light in (before, after)]
    assert np.abs(steps[0] - steps[1]).max() <= 1
    assert before.ticks[2] > after.ticks[2]


def test_longest_frame_is_played(firmware: Path, eeprom: Path) -> None:
    payloads = [bytes(100)] * 4 + [bytes(11)]
    data = frame_to_bytes(ufsook_frame([DataPacket(payload).to_bytes() for payload in payloads]))
    assert len(data) == LENGTH_MAX
    lamp = SimulatedLamp(firmware, eeprom)
    assert set(lamp.load(data)) == {'OK'}
    lamp.run(1.0)
    lamp.power_off()
    lamp = SimulatedLamp(firmware, eeprom)
    assert lamp.ask('s') == f'playing kept {LENGTH_MAX} {data[-2:].hex()} 0'
    lamp.power_off()


def crc_played(firmware: Path, eeprom: Path) -> str:
    """Return the checksum of the kept frame that is played after power up."""
    lamp = SimulatedLamp(firmware, eeprom)
    state, source, _, crc, _ = lamp.ask('s').split()
    lamp.power_off()
    assert (state, source) == ('playing', 'kept')
    return crc


def test_power_cut_while_writing_keeps_one_whole_frame(firmware: Path, eeprom: Path) -> None:
    """Whenever it comes, also within a byte, which then is anything."""
    rng = np.random.default_rng(5)
    old, new = TONE, frame_to_bytes(ufsook_frame([ID]))
    lamp = SimulatedLamp(firmware, eeprom)
    lamp.load(frame_to_bytes(constant_tone_frame(3000.0)))
    lamp.load(old)
    lamp.power_off()
    contents = [eeprom.read_bytes()]
    found = [crc_played(firmware, eeprom)]
    for count in range(1, 60):
        eeprom.write_bytes(contents[0])
        lamp = SimulatedLamp(firmware, eeprom)
        for request in upload_requests(new, keep=True)[:-1]:
            lamp.ask(request)
        lamp.send(b'k\r')
        lamp.write_eeprom(count)
        lamp.power_off()
        contents.append(eeprom.read_bytes())
        found.append(crc_played(firmware, eeprom))
        for at in [i for i in range(1024) if contents[-1][i] != contents[-2][i]]:
            torn = contents[-2][:at] + rng.bytes(1) + contents[-2][at + 1 :]
            eeprom.write_bytes(torn)
            assert crc_played(firmware, eeprom) in (old[-2:].hex(), new[-2:].hex())
    assert len(set(contents)) > 30
    assert list(dict.fromkeys(found)) == [old[-2:].hex(), new[-2:].hex()]


def test_worn_or_strange_eeprom_leaves_the_lamp_shining(firmware: Path, eeprom: Path) -> None:
    for seed in range(5):
        eeprom.write_bytes(np.random.default_rng(seed).bytes(1024))
        lamp = SimulatedLamp(firmware, eeprom)
        assert lamp.ask('s') == 'steady none 0 0000 0'
        assert set(lamp.load(TONE)) == {'OK'}
        lamp.power_off()
