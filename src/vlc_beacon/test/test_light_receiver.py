"""Lamps identified by a constant tone, and small lamps."""

import math
from collections.abc import Iterator
from dataclasses import replace
from functools import partial

import numpy as np
import pytest
from lamp_pictures import draw_lamp, photograph, room
from lamp_scenes import BEACONS, CAMERA, PLACES, id_packets, speaking_room

from scene_simulator.imaging.exposure import Shutter
from shirube_core.waveform import Waveform
from vlc_beacon.core.light_code.rs_fsk import constant_tone_waveform, rs_fsk_waveform
from vlc_beacon.core.light_code.ufsook import ufsook_waveform
from vlc_beacon.core.packet.data_packet import split_message
from vlc_beacon.core.receiver.light_receiver import LightReceiver
from vlc_beacon.core.settings import ReceiverSettings
from vlc_beacon.core.vlc_beacon_error import VlcBeaconError

TONES = (3000.0, 4000.0, 5000.0, 6000.0)
SETTINGS = ReceiverSettings(shutter='rolling', exposure_time=6e-5)


def test_lamps_are_identified_by_their_tones_and_a_constant_one_is_not() -> None:
    beacons = [replace(beacon, frequency=tone) for beacon, tone in zip(BEACONS, TONES, strict=True)]
    receiver = LightReceiver(beacons, SETTINGS)
    drive = speaking_room([constant_tone_waveform(tone) for tone in TONES], Shutter(6e-5, 18.9e-6), 30.0)
    for frame in drive.frames(1.0):
        lamps = receiver.receive(frame.stamp, frame.photo.image)
        places = CAMERA.pixels_from_points(frame.photo.pose.camera_points(PLACES))
        for lamp in lamps:
            if lamp.beacon is not None:
                assert np.hypot(*(places[lamp.beacon - 1] - lamp.sample.centre)) < 4.0
    assert sorted(lamp.beacon for lamp in lamps if lamp.beacon is not None) == [1, 2, 3, 4]
    assert sum(lamp.beacon is None for lamp in lamps) == 1


@pytest.mark.parametrize('number', [1, 3])
def test_frequencies_must_be_given_to_all_lamps_or_none(number: int) -> None:
    beacons = [replace(BEACONS[i], frequency=TONES[i]) if i < number else BEACONS[i] for i in range(4)]
    with pytest.raises(VlcBeaconError, match=f'{number} of 4 have a frequency'):
        LightReceiver(beacons, SETTINGS)


@pytest.mark.parametrize('close', [3000.0, 3199.0])
def test_frequencies_too_close_are_rejected(close: float) -> None:
    tones = (3000.0, 5000.0, close, 4000.0)
    beacons = [replace(beacon, frequency=tone) for beacon, tone in zip(BEACONS, tones, strict=True)]
    with pytest.raises(
        VlcBeaconError, match=f'1 and 3 have the frequencies 3000 Hz and {close:g} Hz; set them 200'
    ):
        LightReceiver(beacons, SETTINGS)
    LightReceiver([*beacons[:2], replace(beacons[2], frequency=3200.0)], SETTINGS)


def film(diameter: float, seconds: float, *, rolling: bool) -> Iterator[tuple[float, np.ndarray]]:
    """Yield stamps and images of four sharp discs without a halo that play their IDs [px, s]."""
    rng, rate = np.random.default_rng(1), 30.003 if rolling else 60.004
    play = (lambda packet: rs_fsk_waveform([packet], 30.0)) if rolling else lambda p: ufsook_waveform([p])
    waveforms = [play(packet) for packet in id_packets()]
    for stamp in np.arange(0.0, seconds, 1.0 / rate):
        picture = room(160, 280)
        for i, waveform in enumerate(waveforms):
            centre = (50 + 60 * i + 8 * math.sin(stamp + i), 80 + 20 * math.sin(0.7 * stamp + 2 * i))
            time = stamp + 0.123 * i
            if rolling:
                share = partial(_rows, waveform, time)
                draw_lamp(picture, centre, 0.5 * diameter, 200.0, rows=share)
            else:
                halves = waveform.exposure_means(time, 5e-4)
                angle = 0.3 * i + 0.2 * stamp
                draw_lamp(picture, centre, 0.5 * diameter, 200.0, halves=halves, angle=angle)
        yield float(stamp), photograph(picture, 1.0, rng)


def _rows(waveform: Waveform, time: float, rows: np.ndarray) -> np.ndarray:
    return waveform.exposure_means(time + rows * SETTINGS.row_time, SETTINGS.exposure_time)[:, 0]


@pytest.mark.parametrize(('rolling', 'diameter', 'seconds'), [(False, 6.0, 3.5), (True, 14.0, 5.5)])
@pytest.mark.newest_set_only
def test_the_smallest_lamps_that_are_promised_get_their_ids(
    rolling: bool, diameter: float, seconds: float
) -> None:
    receiver = LightReceiver(BEACONS, SETTINGS if rolling else ReceiverSettings())
    for stamp, image in film(diameter, seconds, rolling=rolling):
        lamps = receiver.receive(stamp, image)
    assert sorted(str(lamp.beacon) for lamp in lamps) == ['1', '2', '3', '4']


@pytest.mark.newest_set_only
def test_a_long_packet_of_an_unidentified_lamp_is_decoded() -> None:
    (packet,) = split_message('x' * 60)
    waveform = ufsook_waveform([packet.to_bytes()])
    receiver, rng, message = LightReceiver(BEACONS, ReceiverSettings()), np.random.default_rng(1), []
    for stamp in np.arange(0.0, waveform.period + 1.0, 1.0 / 60.004).tolist():
        halves = waveform.exposure_means(stamp - 0.377, 5e-4)
        picture = draw_lamp(room(64, 64), (32.0, 32.0), 8.0, 200.0, halves=halves)
        message += [
            lamp.message for lamp in receiver.receive(stamp, photograph(picture, 1.0, rng)) if lamp.message
        ]
    assert waveform.period > 15.0
    assert message == ['x' * 60]
