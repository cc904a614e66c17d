"""Five lamps in a phone photograph, with known geometry."""

import os
from dataclasses import replace
from pathlib import Path

import cv2
import numpy as np
import pytest

from shirube_core.geometry import CameraMount, PinholeCamera
from vlc_beacon.core.lamp_image.lamp_detector import LampDetector, noise_sigma
from vlc_beacon.core.lamp_image.row_profile import row_profile, rows_from_frame
from vlc_beacon.core.light_code.rs_fsk import tone_log_likelihoods
from vlc_beacon.core.pose.beacon_locator import BeaconLocator
from vlc_beacon.core.pose.lamp_rays import Beacon
from vlc_beacon.core.pose.pose_fix import BeaconFix
from vlc_beacon.core.settings import LampSettings, PoseSettings

PHOTOGRAPH = Path(os.environ.get('SHIRUBE_DATA', 'not given')) / 'vlc_luxapose' / 'x_0_y_1.27.jpg'
FOCAL, ROWS_A_SECOND, LONGEST_STRIPE = 5620.0, 47540.0, 20.0
TONES = (2000.0, 2500.0, 3000.0, 3500.0, 4000.0)
PLAN = ((-35.56, 36.83), (35.56, 36.83), (35.56, -36.83), (-35.56, -36.83), (0.0, 0.0))
HEIGHT = 2.46
# The plan is drawn as one sees it from below: x of a map with z up is the other way.
BEACONS = [Beacon(k + 1, (-x / 100.0, y / 100.0, HEIGHT), 0.02) for k, (x, y) in enumerate(PLAN)]
# A telephone lies about level, and only about.
SETTINGS = PoseSettings(pixel_sigma=3.0, beacon_sigma=0.0, tilt_sigma=0.05)

pytestmark = pytest.mark.skipif(not PHOTOGRAPH.is_file(), reason='SHIRUBE_DATA names no vlc_luxapose/')


@pytest.fixture(scope='module')
def image():
    return cv2.imread(str(PHOTOGRAPH), cv2.IMREAD_GRAYSCALE)


@pytest.fixture(scope='module')
def blobs(image):
    return LampDetector(LampSettings(contrast_min=10.0, stripe_rows=LONGEST_STRIPE)).detect(image)


@pytest.fixture(scope='module')
def played(image, blobs):
    """Return the log likelihoods of the tones for each lamp, shape (lamps, tones)."""
    noise, tables = noise_sigma(image), []
    for centre, radius, background in zip(blobs.centroids, blobs.radii, blobs.backgrounds):
        first, brightness = row_profile(image, centre, radius, background, noise)
        rows = rows_from_frame(0.0, first, brightness, 1.0 / ROWS_A_SECOND, 5e-5)
        tables.append(tone_log_likelihoods(rows, TONES)[0])
    return np.array(tables)


def test_all_five_lamps_and_nothing_else_are_found_and_their_frequencies_identified(blobs, played):
    assert len(blobs) == 5
    assert (blobs.roundness > 0.6).all()
    assert sorted(played.argmax(axis=1)) == [0, 1, 2, 3, 4]
    ordered = np.sort(played, axis=1)
    assert (ordered[:, -1] - ordered[:, -2]).min() > 8.0


def test_the_lamps_give_the_pose_of_the_telephone(image, blobs, played):
    height, width = image.shape
    camera = PinholeCamera(width, height, FOCAL, FOCAL, 0.5 * (width - 1), 0.5 * (height - 1))
    ids = 1 + played.argmax(axis=1)
    other_way = [replace(b, xyz=(-b.xyz[0], *b.xyz[1:])) for b in BEACONS]
    locator, mirrored = (
        BeaconLocator(lamps, CameraMount((0.0,) * 3, (0.0,) * 3), None, SETTINGS)
        for lamps in (BEACONS, other_way)
    )
    rays = locator.rays(camera, ids, blobs.centroids, blobs.sigmas.max(axis=1))
    fix = locator.locate(rays)
    assert isinstance(fix, BeaconFix)
    assert fix.used.all()
    assert fix.anomalies == ()
    pixels = fix.residuals * np.hypot(rays.sigmas, SETTINGS.pixel_sigma)[:, None]
    assert np.sqrt(np.mean(pixels**2)) < 3.0
    # The lamps hang 2.46 m over the telephone, which lies within centimetres of the plan's middle.
    assert fix.height == pytest.approx(0.0, abs=0.03)
    assert np.hypot(fix.T_map_base.x, fix.T_map_base.y) < 0.04
    assert mirrored.locate(rays).anomalies
