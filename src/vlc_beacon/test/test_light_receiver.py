"""Lamps that are told by a constant tone."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from lamp_scenes import BEACONS, CAMERA, PLACES, speaking_room

from scene_simulator.shutter import Shutter
from vlc_beacon.core.light_code.rs_fsk import constant_tone_waveform
from vlc_beacon.core.receiver.light_receiver import LightReceiver
from vlc_beacon.core.receiver.settings import ReceiverSettings
from vlc_beacon.core.vlc_beacon_error import VlcBeaconError

TONES = (3000.0, 4000.0, 5000.0, 6000.0)
SETTINGS = ReceiverSettings(shutter='rolling', exposure_time=6e-5)


def test_lamps_are_told_by_their_tones_and_a_steady_one_is_none_of_them() -> None:
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
