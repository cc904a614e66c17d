"""Coded lamps in real photographs of a telephone, with known geometry, among other lights."""

import os
from dataclasses import replace
from pathlib import Path
from types import ModuleType
from typing import Any

import numpy as np
import pytest

from shirube_core.geometry import CameraMount
from vlc_beacon.core.pose.beacon_locator import BeaconLocator
from vlc_beacon.core.pose.pose_fix import BeaconFix

BENCHMARK = 'lamp_photograph'
DATA = Path(os.environ.get('SHIRUBE_DATA', 'not given'))

pytestmark = pytest.mark.skipif(not (DATA / 'vlc_luxapose').is_dir(), reason='SHIRUBE_DATA names no vlc_luxapose/')


@pytest.fixture(scope='module')
def photograph(bench: ModuleType) -> Any:
    return bench.read_photograph(DATA / 'vlc_luxapose' / 'x_0_y_1.27.jpg')


def test_all_five_lamps_and_nothing_else_are_found_and_their_frequencies_identified(photograph: Any) -> None:
    assert len(photograph.blobs) == 5
    assert (photograph.blobs.roundness > 0.6).all()
    assert sorted(photograph.played.argmax(axis=1)) == [0, 1, 2, 3, 4]
    ordered = np.sort(photograph.played, axis=1)
    assert (ordered[:, -1] - ordered[:, -2]).min() > 8.0


def test_the_lamps_give_the_pose_of_the_telephone(bench: ModuleType, photograph: Any) -> None:
    rays, fix = photograph.locate()
    assert isinstance(fix, BeaconFix)
    assert fix.used.all()
    assert fix.anomalies == ()
    pixels = fix.residuals * np.hypot(rays.sigmas, bench.SETTINGS.pixel_sigma)[:, None]
    assert np.sqrt(np.mean(pixels**2)) < 3.0
    # The lamps hang 2.46 m over the telephone, which lies within centimetres of the plan's middle.
    assert fix.height == pytest.approx(0.0, abs=0.03)
    assert np.hypot(fix.T_map_base.x, fix.T_map_base.y) < 0.04
    mirrored = [replace(b, xyz=(-b.xyz[0], *b.xyz[1:])) for b in bench.BEACONS]
    assert BeaconLocator(mirrored, CameraMount((0.0,) * 3, (0.0,) * 3), None, bench.SETTINGS).locate(rays).anomalies


@pytest.mark.skipif(not (DATA / 'vlc_luxapose_more').is_dir(), reason='SHIRUBE_DATA names no vlc_luxapose_more/')
def test_the_lamps_are_named_and_other_lights_are_not(bench: ModuleType) -> None:
    assert bench.names_in_photographs(DATA / 'vlc_luxapose_more') == [
        ('2014-02-27--18-15-03-62.jpg', 3, 3, 3, []),
        ('2013-05-11--02-08-21-25.jpg', 4, 4, 4, [None] * 3),
    ]
