"""Five lamps in a telephone's photograph: which frequency each plays, and the pose with its residuals.

The photograph is Luxapose's x_0_y_1.27.jpg (SHIRUBE_DATA, ``vlc_luxapose/``): a rolling shutter, five lamps of 2 to
4 kHz whose places are known.
"""

from __future__ import annotations

import math

import cv2
import numpy as np
from _figures import count, rate, rms
from _harness import Run, run_benchmark, use_one_core
from numpy.typing import NDArray

from shirube_core.geometry import CameraMount, PinholeCamera
from vlc_beacon.core.lamp_image.blob_measurement import LampBlobs
from vlc_beacon.core.lamp_image.lamp_detector import LampDetector, noise_sigma
from vlc_beacon.core.lamp_image.row_profile import row_profile, rows_from_frame
from vlc_beacon.core.light_code.rs_fsk import tone_log_likelihoods
from vlc_beacon.core.pose.beacon_locator import BeaconLocator
from vlc_beacon.core.pose.lamp_rays import Beacon
from vlc_beacon.core.pose.pose_fix import BeaconFix
from vlc_beacon.core.settings import LampSettings, PoseSettings

FOCAL, ROWS_A_SECOND, EXPOSURE, LONGEST_STRIPE = 5620.0, 47540.0, 5e-5, 20.0
"""Of the telephone [px, 1/s, s], and of the slowest lamp in it [px]."""
TONES = (2000.0, 2500.0, 3000.0, 3500.0, 4000.0)
"""[Hz]"""
HEIGHT = 2.46
# The plan is drawn as one sees it from below: x of a map with z up is the other way.
PLAN = ((35.56, 36.83), (-35.56, 36.83), (-35.56, -36.83), (35.56, -36.83), (0.0, 0.0))
"""Of the lamps, in the order of their tones [cm]."""
BEACONS = [Beacon(k + 1, (x / 100.0, y / 100.0, HEIGHT), 0.02) for k, (x, y) in enumerate(PLAN)]
LEVEL = CameraMount((0.0, 0.0, 0.0), (0.0, 0.0, 0.0))
# A telephone is about level, and its lens is not calibrated.
SETTINGS = PoseSettings(pixel_sigma=3.0, beacon_sigma=0.0, tilt_sigma=0.05)


def likelihoods(image: NDArray[np.uint8], blobs: LampBlobs) -> NDArray[np.float64]:
    """Return the log likelihoods of the tones, shape (lamps, tones)."""
    noise, table = noise_sigma(image), []
    for centre, radius, background in zip(blobs.centroids, blobs.radii, blobs.backgrounds, strict=True):
        first, brightness = row_profile(image, centre, radius, background, noise)
        rows = rows_from_frame(0.0, first, brightness, 1.0 / ROWS_A_SECOND, EXPOSURE)
        table.append(tone_log_likelihoods(rows, TONES)[0])
    return np.array(table)


def main(run: Run) -> None:
    """Find the lamps and the pose."""
    use_one_core()
    path = run.data('vlc_luxapose', 'x_0_y_1.27.jpg')
    grey = np.asarray(cv2.imread(str(path), cv2.IMREAD_GRAYSCALE), np.uint8)
    blobs = LampDetector(LampSettings(contrast_min=10.0, stripe_rows=LONGEST_STRIPE)).detect(grey)
    played = likelihoods(grey, blobs)
    ids, ordered = 1 + played.argmax(axis=1), np.sort(played, axis=1)
    height, width = grey.shape
    camera = PinholeCamera(width, height, FOCAL, FOCAL, 0.5 * (width - 1), 0.5 * (height - 1))
    locator = BeaconLocator(BEACONS, LEVEL, None, SETTINGS)
    rays = locator.rays(camera, ids, blobs.centroids, blobs.sigmas.max(axis=1))
    fix = locator.locate(rays)
    if not isinstance(fix, BeaconFix):
        run.note(f'No pose: {fix}')
        return
    residuals = fix.residuals * np.hypot(rays.sigmas, SETTINGS.pixel_sigma)[:, None]
    heads: tuple[str, ...] = ('frequency Hz', 'diameter px', 'ahead of the next by (log likelihood)')
    table = run.table('Lamps', 'lamp', *heads, 'residual px: rms')
    for k in np.argsort(ids):
        ahead = count(ordered[k, -1] - ordered[k, -2], '.0f', better='higher')
        table.add(
            *(str(ids[k]), f'{TONES[ids[k] - 1]:.0f}', count(2.0 * blobs.radii[k], '.0f')),
            *(ahead, rms(residuals[k], '.1f')),
        )
    pose, (roll, pitch) = fix.T_map_base, np.degrees(fix.tilt)
    heads = 'lamps found', 'x cm', 'y cm', 'z cm', 'yaw °', 'tilt °', 'residuals px: rms', 'at the lamps mm'
    run.table('Pose; the telephone was about under the middle lamp, at z = 0', 'photograph', *heads).add(
        *(path.name, rate(len(blobs), len(BEACONS))),
        *(count(100.0 * value, '.1f') for value in (pose.x, pose.y, fix.height)),
        *(count(math.degrees(pose.yaw), '.1f'), f'{roll:.2f}, {pitch:.2f}'),
        *(rms(residuals, '.2f'), rms(residuals, '.2f', 1e3 * HEIGHT / FOCAL)),
    )


if __name__ == '__main__':
    run_benchmark(main)
