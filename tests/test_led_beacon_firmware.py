"""The light of the lamp's firmware in a simulated ATmega328P: tick by tick, and read by the receivers."""

from dataclasses import replace

import numpy as np
import pytest
from lamp_frame_reading import waveform_from_frame
from light_channel import COMMAND, HUNDRED, SEGMENTS, packets_in, waveform_of
from simulated_lamp import TICK_RATE, Light, SimulatedLamp

from shirube_core.waveform import Waveform
from vlc_beacon.core.light_code.rs_fsk import constant_tone_waveform
from vlc_beacon.core.packet.data_packet import DataPacket, IdPacket
from vlc_beacon.core.packet.packet_reader import Packet
from vlc_beacon.core.transmitter.lamp_frame import (
    STEP_FRACTION,
    STEP_TICKS_MIN,
    LampFrame,
    PulseTrain,
    Section,
    frame_to_bytes,
)
from vlc_beacon.core.transmitter.lamp_program import constant_tone_frame, manchester_frame, rs_fsk_frame, ufsook_frame

pytestmark = pytest.mark.newest_set_only

ID = IdPacket(4711)
TEXT = DataPacket('曲がる'.encode(), is_text=True)


def bytes_of(*packets: Packet) -> list[bytes]:
    return [packet.to_bytes() for packet in packets]


def light_of(lamp: SimulatedLamp, frame: LampFrame, periods: int = 1) -> Light:
    """Return how a lamp shines that is given a frame."""
    assert set(lamp.load(frame_to_bytes(frame))) == {'OK'}
    lamp.run(periods * waveform_from_frame(frame).period + 0.01)
    return lamp.power_off()


def played(light: Light, frame: LampFrame, periods: int) -> Waveform:
    """Return whole periods of a light that began with a frame."""
    expected = waveform_from_frame(frame)
    start = light.first_dark() - round(float(expected.times[1]) * TICK_RATE)
    return light.waveform(start, expected.period * TICK_RATE, periods)


def switches(waveform: Waveform, periods: int) -> tuple[np.ndarray, np.ndarray]:
    """Return when and to what both halves change, from the first change on [ticks]."""
    halves = np.broadcast_to(waveform.levels, (len(waveform.levels), 2))
    times = np.concatenate([waveform.times + i * waveform.period for i in range(periods)]) * TICK_RATE
    states = np.tile(halves @ [1, 2], periods).astype(int)
    changes = np.flatnonzero(states[1:] != states[:-1]) + 1
    return times[changes] - times[changes[0]], states[changes]


CODES = {
    'ufsook': (ufsook_frame(bytes_of(ID, TEXT)), waveform_of('ufsook', [ID, TEXT]), 2),
    'rs_fsk': (rs_fsk_frame(bytes_of(ID, TEXT), 30.0), waveform_of('rs_fsk', [ID, TEXT]), 2),
    'manchester': (manchester_frame(bytes_of(ID, HUNDRED), SEGMENTS), waveform_of('manchester', [ID, HUNDRED]), 1),
    'tone': (constant_tone_frame(3333.0), constant_tone_waveform(3333.0), 100),
}


@pytest.mark.parametrize('code', CODES)
def test_light_is_the_codes_waveform_within_a_tick(lamp: SimulatedLamp, code: str) -> None:
    frame, waveform, periods = CODES[code]
    light = light_of(lamp, frame, periods)
    times, states = switches(waveform, periods)
    first = np.flatnonzero(light.ticks == light.first_dark())[0]
    seen = slice(first, first + len(times))
    assert light.states[seen].tolist() == states.tolist()
    late = light.ticks[seen] - light.first_dark() - times
    assert np.abs(late - late.mean()).max() <= 1.0


def test_nothing_on_the_line_moves_the_light(lamp: SimulatedLamp) -> None:
    """Steps as short as they may be, a packet in each, frames that take turns, and a line that never rests."""
    step = STEP_TICKS_MIN * STEP_FRACTION
    trains = tuple(PulseTrain(6 + i % 2, 1, step) for i in range(8))
    frame = LampFrame((0, 3) * 4, 3, trains, (), [Section(np.array([[i % 2]])) for i in range(4)])
    lamp.load(frame_to_bytes(frame))
    for _ in range(10):
        assert set(lamp.load(frame_to_bytes(replace(frame, plays=1)), keep=False)) == {'OK'}
        lamp.send(b's\rv\rd 0 00\r' * 20)
        lamp.run(0.2)
    light = lamp.power_off()
    steps = np.diff(light.ticks[2:])
    # Where frames take turns after an odd section, its level comes twice.
    assert set(steps.tolist()) <= {STEP_TICKS_MIN, 2 * STEP_TICKS_MIN}
    assert (steps == STEP_TICKS_MIN).sum() > 10_000
    assert light.preparation < 0.8 * STEP_TICKS_MIN


@pytest.mark.parametrize(
    ('code', 'frame', 'packets', 'periods', 'seconds'),
    [
        ('ufsook', ufsook_frame(bytes_of(ID, COMMAND, TEXT)), {ID, COMMAND, TEXT}, 2, 40.0),
        ('rs_fsk', rs_fsk_frame(bytes_of(ID, COMMAND, TEXT), 30.0), {ID, COMMAND, TEXT}, 1, 40.0),
        ('manchester', CODES['manchester'][0], {ID, HUNDRED}, 1, 20.0),
    ],
)
def test_a_camera_reads_the_light(lamp, code, frame, packets, periods, seconds) -> None:
    light = played(light_of(lamp, frame, periods), frame, periods)
    assert set(packets_in(light, code, seconds, 1)) == packets
