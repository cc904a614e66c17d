"""Lamps identified by a constant tone, and small lamps."""

import math
from collections.abc import Iterator
from dataclasses import replace

import numpy as np
import pytest
from lamp_pictures import draw_lamp, photograph, room
from lamp_scenes import BEACONS, CAMERA, PLACES, speaking_room
from light_channel import waveform_of

from scene_simulator.imaging.exposure import Shutter
from vlc_beacon.core.light_code.rs_fsk import constant_tone_waveform
from vlc_beacon.core.packet.data_packet import IdPacket, split_message
from vlc_beacon.core.pose.lamp_rays import Beacon
from vlc_beacon.core.receiver.light_receiver import LightReceiver
from vlc_beacon.core.settings import ReceiverSettings
from vlc_beacon.core.vlc_beacon_error import VlcBeaconError

TONES = (3000.0, 4000.0, 5000.0, 6000.0)
SETTINGS = ReceiverSettings(shutter='rolling', row_time=18.9e-6, exposure_time=6e-5)


def test_lamps_are_identified_by_their_tones_and_a_constant_one_is_not() -> None:
    receiver = LightReceiver(beacons_with(*TONES), SETTINGS)
    drive = speaking_room([constant_tone_waveform(tone) for tone in TONES], Shutter(6e-5, 18.9e-6), 30.0)
    for frame in drive.frames(1.0):
        lamps = receiver.receive(frame.stamp, frame.photo.image)
        places = CAMERA.pixels_from_points(frame.photo.pose.camera_points(PLACES))
        for lamp in lamps:
            if lamp.beacon is not None:
                assert np.hypot(*(places[lamp.beacon - 1] - lamp.sample.centre)) < 4.0
    assert sorted(lamp.beacon for lamp in lamps if lamp.beacon is not None) == [1, 2, 3, 4]
    assert sum(lamp.beacon is None for lamp in lamps) == 1


def beacons_with(*tones: float | None) -> list[Beacon]:
    return [replace(beacon, frequency=tone) for beacon, tone in zip(BEACONS, tones)]


@pytest.mark.parametrize(
    ('tones', 'complaint'),
    [
        ((3000.0, None, None, None), '1 of 4 have a frequency'),
        ((3000.0, 4000.0, 5000.0, None), '3 of 4 have a frequency'),
        *(
            ((3000.0, 5000.0, near, 4000.0), f'1 and 3 have the frequencies 3000 Hz and {near:g} Hz; set them 200')
            for near in (3000.0, 3199.0)
        ),
    ],
)
def test_frequencies_must_be_given_to_all_lamps_or_none_and_differ(tones, complaint: str) -> None:
    with pytest.raises(VlcBeaconError, match=complaint):
        LightReceiver(beacons_with(*tones), SETTINGS)
    LightReceiver(beacons_with(3000.0, 5000.0, 3200.0), SETTINGS)


def film(diameter: float, seconds: float, *, rolling: bool) -> Iterator[tuple[float, np.ndarray]]:
    """Yield stamps and images of four sharp discs without a halo that play their IDs [px, s]."""
    rng, rate = np.random.default_rng(1), 30.003 if rolling else 60.004
    waveforms = [waveform_of('rs_fsk' if rolling else 'ufsook', [IdPacket(i + 1)]) for i in range(4)]
    for stamp in np.arange(0.0, seconds, 1.0 / rate):
        picture = room(160, 280)
        for i, waveform in enumerate(waveforms):
            centre = (50 + 60 * i + 8 * math.sin(stamp + i), 80 + 20 * math.sin(0.7 * stamp + 2 * i))
            time = stamp + 0.123 * i
            halves = {'halves': waveform.exposure_means(time, 5e-4), 'angle': 0.3 * i + 0.2 * stamp}
            rows = {'rows': lambda v, w=waveform, t=time: w.exposure_means(t + v * 18.9e-6, 6e-5)[:, 0]}
            draw_lamp(picture, centre, 0.5 * diameter, 200.0, **(rows if rolling else halves))
        yield float(stamp), photograph(picture, 1.0, rng)


@pytest.mark.parametrize(('rolling', 'diameter', 'seconds'), [(False, 6.0, 3.5), (True, 14.0, 5.5)])
@pytest.mark.newest_set_only
def test_the_smallest_lamps_that_are_promised_get_their_ids(rolling, diameter, seconds) -> None:
    receiver = LightReceiver(BEACONS, SETTINGS if rolling else ReceiverSettings())
    for stamp, image in film(diameter, seconds, rolling=rolling):
        lamps = receiver.receive(stamp, image)
    assert sorted(str(lamp.beacon) for lamp in lamps) == ['1', '2', '3', '4']


@pytest.mark.newest_set_only
def test_a_long_packet_of_an_unidentified_lamp_is_decoded() -> None:
    (packet,) = split_message('x' * 60)
    waveform = waveform_of('ufsook', [packet])
    receiver, rng, message = LightReceiver(BEACONS, ReceiverSettings()), np.random.default_rng(1), []
    for stamp in np.arange(0.0, waveform.period + 1.0, 1.0 / 60.004).tolist():
        halves = waveform.exposure_means(stamp - 0.377, 5e-4)
        picture = draw_lamp(room(64, 64), (32.0, 32.0), 8.0, 200.0, halves=halves)
        lamps = receiver.receive(stamp, photograph(picture, 1.0, rng))
        message += [lamp.message for lamp in lamps if lamp.message]
    assert waveform.period > 15.0
    assert message == ['x' * 60]
