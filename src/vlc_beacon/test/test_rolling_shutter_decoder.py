"""Manchester segments on a large lamp, from images to packets."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from lamp_pictures import draw_lamp, photograph, room

from vlc_beacon.core.lamp_image.settings import LampSettings
from vlc_beacon.core.light_code.lamp_rows import rows_of_frame
from vlc_beacon.core.light_code.light_profile import manchester_profile
from vlc_beacon.core.light_code.manchester import SlotFormat, slots_waveform
from vlc_beacon.core.light_code.manchester_decoder import ManchesterDecoder
from vlc_beacon.core.light_code.reed_solomon_block import slots_of_packet
from vlc_beacon.core.packet.command_packet import Command, CommandPacket
from vlc_beacon.core.packet.id_packet import IdPacket
from vlc_beacon.core.packet.operation import Operation
from vlc_beacon.core.pose.beacon import Beacon
from vlc_beacon.core.receiver.light_receiver import LightReceiver, ReadLamp
from vlc_beacon.core.receiver.row_timing import row_timing
from vlc_beacon.core.receiver.settings import ReceiverSettings

HEIGHT, WIDTH = 560, 480
ROW_TIME, EXPOSURE, RATE = 18.9e-6, 6e-5, 30.003
BEACON = Beacon(5, (0.0, 0.0, 2.5), 0.5)
COMMAND = CommandPacket(Command(5, Operation.SLOW, 0.125, 7), b'abcd')
SLOTS = SlotFormat()


def settings(diameter_max: float) -> ReceiverSettings:
    lamps = LampSettings(diameter_max=diameter_max)
    return ReceiverSettings(shutter='rolling', row_time=ROW_TIME, exposure_time=EXPOSURE, lamps=lamps)


def read(diameter: float, seconds: float) -> tuple[ReadLamp, list[CommandPacket]]:
    """Return a lamp that plays its ID and a command in slots, after a while, and the commands that were heard."""
    packets = [IdPacket(BEACON.id).to_bytes()] * 2 + [COMMAND.to_bytes()]
    slots = [slot for packet in packets for slot in slots_of_packet(packet, SLOTS.slot_bytes)]
    light, rng = slots_waveform(slots, SLOTS, 1.00005), np.random.default_rng(1)
    centre = (238.3, 281.6)
    lamp = draw_lamp(room(HEIGHT, WIDTH, 0.0), centre, 0.5 * diameter, 190.0)
    receiver, heard = LightReceiver([BEACON], settings(450.0)), []
    for stamp in np.arange(0.0, seconds, 1.0 / RATE).tolist():
        shares = light.exposed(stamp + np.arange(HEIGHT) * ROW_TIME, EXPOSURE)
        (found,) = receiver.receive(stamp, photograph(4.0 + shares * lamp, 1.5, rng))
        heard += found.heard
    return found, heard


@pytest.mark.newest_set_only
def test_a_large_lamp_is_read_in_slots() -> None:
    lamp, heard = read(340.0, 4.0)
    assert lamp.beacon == BEACON.id
    assert set(heard) == {COMMAND}
    assert lamp.sample.centre == pytest.approx((238.3, 281.6), abs=1.0)


def test_larger_slots_are_read_by_who_knows_of_them() -> None:
    slots = SlotFormat(4)
    waveform = slots_waveform(slots_of_packet(COMMAND.to_bytes(), slots.slot_bytes), slots, 1.00005)
    heard = {}
    for size in (1, 4):
        told = replace(settings(450.0), slot_bytes=size)
        decoder = ManchesterDecoder(row_timing(told, ()).slots)
        rows = slots.rows_min(ROW_TIME, EXPOSURE) + 20
        packets = []
        for stamp in np.arange(0.0, 2.0, 1.0 / RATE).tolist():
            seen = waveform.exposed(stamp + np.arange(rows) * ROW_TIME, EXPOSURE)[:, 0]
            packets += decoder.add_frames(rows_of_frame(stamp, 0, seen, ROW_TIME, EXPOSURE))
        heard[size] = {received.packet for received in packets}
    assert heard == {1: set(), 4: {COMMAND}}


def test_a_lamp_of_fewer_rows_than_the_profile_asks_for_is_not_read() -> None:
    rows_min = manchester_profile(SLOTS, ROW_TIME, EXPOSURE).rows_min
    lamp, heard = read(rows_min - 20.0, 2.0)
    assert (lamp.beacon, heard) == (None, [])
