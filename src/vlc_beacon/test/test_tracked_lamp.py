"""Lamps that flicker without a code, and lamps that start to send late."""

import math

import numpy as np
import pytest

from vlc_beacon.core.authorization.keys_and_counters import CommandKey
from vlc_beacon.core.lamp_image.lamp_tracker import LampSample
from vlc_beacon.core.light_code.ufsook import ufsook_waveform
from vlc_beacon.core.packet.command_packet import Command, Operation, shorten
from vlc_beacon.core.packet.data_packet import IdPacket
from vlc_beacon.core.packet.packet_reader import ReceivedPacket
from vlc_beacon.core.receiver.lamp_decoder import GlobalShutterDecoder, LampView
from vlc_beacon.core.receiver.light_receiver import BACKOFF_TIME, SkipReason, TrackedLamp

RATE, EXPOSURE, LISTEN = 60.004, 5e-4, 15.0
NOTHING = np.zeros((16, 16), np.uint8)


class CountingDecoder(GlobalShutterDecoder):
    reads = 0

    def read(self, view):
        self.reads += 1
        return super().read(view)


def mains(frequency):
    """Return the light of a lamp on the mains: it goes out twice a cycle."""
    return lambda stamp: np.full(2, math.sin(math.pi * frequency * stamp) ** 2)


def speaking(packet):
    waveform = ufsook_waveform([packet.to_bytes()])
    return lambda stamp: waveform.exposure_means(stamp, EXPOSURE)


def watch(lamp, light, begin, seconds, diameter=16.0):
    """Let a lamp be seen for a while and return its last observation."""
    for stamp in np.arange(begin, begin + seconds, 1.0 / RATE):
        sample = LampSample(1, np.zeros(2), np.full(2, 0.1), 0.5 * diameter, light(stamp), None, 0)
        seen = lamp.update(LampView(float(stamp), NOTHING, sample, 0.0))
    return seen


@pytest.mark.parametrize(
    ('frequency', 'diameter', 'reason'),
    [*((hertz, 16.0, SkipReason.NO_CODE) for hertz in (100.0, 120.0, 100.2)), (100.0, 5.0, SkipReason.TOO_SMALL)],
)
def test_a_lamp_on_the_mains_or_too_small_is_left_alone_in_the_end(frequency, diameter, reason):
    decoder = CountingDecoder(EXPOSURE)
    lamp = TrackedLamp(decoder, {1}, 6.0, LISTEN)
    assert watch(lamp, mains(frequency), 0.0, LISTEN - 1.0, diameter).skip_reason is None
    seen = watch(lamp, mains(frequency), LISTEN - 1.0, BACKOFF_TIME, diameter)
    assert seen.skip_reason is reason
    assert decoder.reads == pytest.approx(LISTEN * RATE, abs=2)
    assert (seen.beacon, seen.unknown_id) == (None, None)


def test_a_lamp_that_was_switched_on_is_found_in_the_end():
    lamp = TrackedLamp(GlobalShutterDecoder(EXPOSURE), {7}, 6.0, LISTEN)
    seen = watch(lamp, mains(100.0), 0.0, LISTEN + BACKOFF_TIME - 1.0)
    assert seen.skip_reason is SkipReason.NO_CODE
    seen = watch(lamp, speaking(IdPacket(7)), LISTEN + BACKOFF_TIME, 8.0)
    assert (seen.beacon, seen.skip_reason) == (7, None)


def test_a_named_lamp_is_listened_to_for_ever():
    decoder = CountingDecoder(EXPOSURE)
    lamp = TrackedLamp(decoder, {7}, 6.0, LISTEN)
    watch(lamp, speaking(IdPacket(7)), 0.0, 5.0)
    reads = decoder.reads
    seen = watch(lamp, mains(100.0), 5.0, 2.0 * LISTEN)
    assert (seen.beacon, seen.skip_reason) == (7, None)
    assert decoder.reads - reads == pytest.approx(2.0 * LISTEN * RATE, abs=2)


@pytest.mark.parametrize('number', [7, 8])
def test_a_short_command_waits_for_the_id_of_its_lamp_and_is_then_addressed_to_it(number: int) -> None:
    signed = CommandKey(bytes(32)).sign(Command(7, Operation.TURN, -1.5708, 5))
    short = shorten(signed)
    packets = [IdPacket(number), IdPacket(number), short, short]
    decoder = type('Decoder', (), {'read': lambda _, view: [ReceivedPacket(view.stamp, packets.pop())]})()
    lamp = TrackedLamp(decoder, {7}, 6.0, LISTEN)
    commands = [watch(lamp, mains(1.0), float(second), 0.01).commands for second in range(4)]
    known = (short.addressed_to(7),) if number == 7 else ()
    assert commands == [(), (), (), known * 2]
    assert not known or known == (signed,)


def test_an_id_is_confirmed_by_two_consecutive_packets() -> None:
    packets = [IdPacket(number) for number in (2, 2, 1, 1, 1, 2, 1)]
    decoder = type('Decoder', (), {'read': lambda _, view: [ReceivedPacket(view.stamp, packets.pop())]})()
    lamp = TrackedLamp(decoder, {1, 2}, 6.0, LISTEN)
    assert [watch(lamp, mains(1.0), float(k), 0.01).beacon for k in range(7)] == [None, None, None, 1, 1, 1, 2]
