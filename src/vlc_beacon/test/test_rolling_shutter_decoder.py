"""Manchester segments on a large lamp, from images to packets."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from lamp_pictures import draw_lamp, photograph, room

from vlc_beacon.core.lamp_image.settings import LampSettings
from vlc_beacon.core.light_code.code_profile import manchester_profile
from vlc_beacon.core.light_code.lamp_rows import rows_from_frame
from vlc_beacon.core.light_code.manchester import SegmentFormat, segments_waveform
from vlc_beacon.core.light_code.manchester_decoder import ManchesterDecoder
from vlc_beacon.core.light_code.reed_solomon_block import segments_from_packet
from vlc_beacon.core.packet.command_packet import Command, CommandPacket
from vlc_beacon.core.packet.id_packet import IdPacket
from vlc_beacon.core.packet.operation import Operation
from vlc_beacon.core.pose.beacon import Beacon
from vlc_beacon.core.receiver.light_receiver import LampObservation, LightReceiver
from vlc_beacon.core.receiver.row_timing import row_timing
from vlc_beacon.core.receiver.settings import ReceiverSettings

HEIGHT, WIDTH = 560, 480
ROW_TIME, EXPOSURE, RATE = 18.9e-6, 6e-5, 30.003
BEACON = Beacon(5, (0.0, 0.0, 2.5), 0.5)
COMMAND = CommandPacket(Command(5, Operation.SLOW, 0.125, 7), b'abcd')
SLOTS = SegmentFormat()


def settings(diameter_max: float) -> ReceiverSettings:
    lamps = LampSettings(diameter_max=diameter_max)
    return ReceiverSettings(shutter='rolling', row_time=ROW_TIME, exposure_time=EXPOSURE, lamps=lamps)


def read(diameter: float, seconds: float) -> tuple[LampObservation, list[CommandPacket]]:
    """Return a lamp that plays its ID and a command in slots, after a while, and the commands that were heard."""
    packets = [IdPacket(BEACON.id).to_bytes()] * 2 + [COMMAND.to_bytes()]
    segments = [
        segment for packet in packets for segment in segments_from_packet(packet, SLOTS.segment_bytes)
    ]
    light, rng = segments_waveform(segments, SLOTS, 1.00005), np.random.default_rng(1)
    centre = (238.3, 281.6)
    lamp = draw_lamp(room(HEIGHT, WIDTH, 0.0), centre, 0.5 * diameter, 190.0)
    receiver, commands = LightReceiver([BEACON], settings(450.0)), []
    for stamp in np.arange(0.0, seconds, 1.0 / RATE).tolist():
        shares = light.exposure_means(stamp + np.arange(HEIGHT) * ROW_TIME, EXPOSURE)
        (found,) = receiver.receive(stamp, photograph(4.0 + shares * lamp, 1.5, rng))
        commands += found.commands
    return found, commands


@pytest.mark.newest_set_only
def test_a_large_lamp_is_decoded_in_segments() -> None:
    lamp, commands = read(340.0, 4.0)
    assert lamp.beacon == BEACON.id
    assert set(commands) == {COMMAND}
    assert lamp.sample.centre == pytest.approx((238.3, 281.6), abs=1.0)


def test_larger_segments_need_the_same_setting() -> None:
    segments = SegmentFormat(4)
    waveform = segments_waveform(
        segments_from_packet(COMMAND.to_bytes(), segments.segment_bytes), segments, 1.00005
    )
    commands = {}
    for size in (1, 4):
        told = replace(settings(450.0), segment_bytes=size)
        decoder = ManchesterDecoder(row_timing(told, ()).segments)
        rows = segments.rows_min(ROW_TIME, EXPOSURE) + 20
        packets = []
        for stamp in np.arange(0.0, 2.0, 1.0 / RATE).tolist():
            seen = waveform.exposure_means(stamp + np.arange(rows) * ROW_TIME, EXPOSURE)[:, 0]
            packets += decoder.add_frames(rows_from_frame(stamp, 0, seen, ROW_TIME, EXPOSURE))
        commands[size] = {received.packet for received in packets}
    assert commands == {1: set(), 4: {COMMAND}}


def test_a_lamp_of_fewer_rows_than_the_profile_asks_for_is_not_read() -> None:
    rows_min = manchester_profile(SLOTS, ROW_TIME, EXPOSURE).rows_min
    lamp, commands = read(rows_min - 20.0, 2.0)
    assert (lamp.beacon, commands) == (None, [])
