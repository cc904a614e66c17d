"""Five lamps in a telephone's photograph: `SHIRUBE_DATA=FOLDER ./shirube bench lamp_photograph`.

The photograph is Luxapose's x_0_y_1.27.jpg in FOLDER/vlc_luxapose: a rolling shutter, five lamps of 2 to 4 kHz whose
places are known. Prints what is found, which frequency each lamp plays, and the pose with its residuals.
"""

from __future__ import annotations

import argparse
import os
import sys
from pathlib import Path

import cv2
import numpy as np
from _timed_answers import use_one_core
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

NAME = Path('vlc_luxapose') / 'x_0_y_1.27.jpg'
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


def main() -> int:
    """Print the tables; return 1 without the photograph or without the pose."""
    argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    ).parse_args()
    path = Path(os.environ.get('SHIRUBE_DATA', '.')) / NAME
    image = cv2.imread(str(path), cv2.IMREAD_GRAYSCALE)
    if image is None:
        print(
            f'{path}: no photograph; set SHIRUBE_DATA to the folder that holds vlc_luxapose/', file=sys.stderr
        )
        return 1
    use_one_core()
    grey = np.asarray(image, np.uint8)
    blobs = LampDetector(LampSettings(contrast_min=10.0, stripe_rows=LONGEST_STRIPE)).detect(grey)
    played = likelihoods(grey, blobs)
    ids = 1 + played.argmax(axis=1)
    camera = PinholeCamera(
        grey.shape[1], grey.shape[0], FOCAL, FOCAL, 0.5 * (grey.shape[1] - 1), 0.5 * (grey.shape[0] - 1)
    )
    locator = BeaconLocator(BEACONS, LEVEL, None, SETTINGS)
    rays = locator.rays(camera, ids, blobs.centroids, blobs.sigmas.max(axis=1))
    fix = locator.locate(rays)
    if not isinstance(fix, BeaconFix):
        print(f'no pose: {fix}', file=sys.stderr)
        return 1
    print(f'{camera.width} x {camera.height} pixels, {len(blobs)} lamps found of {len(BEACONS)}.\n')
    print_lamps(blobs, played, ids, fix.residuals * np.hypot(rays.sigmas, SETTINGS.pixel_sigma)[:, None])
    print_pose(fix)
    return 0


def print_lamps(
    blobs: LampBlobs, played: NDArray[np.float64], ids: NDArray[np.int64], residuals: NDArray[np.float64]
) -> None:
    """Print a line for each lamp; residuals have the shape (n, 2) [px]."""
    print(
        '| lamp | centre px | diameter px | frequency Hz | ahead of the next by (log likelihood) | residual px |'
    )
    print('|---|---|---|---|---|---|')
    ordered = np.sort(played, axis=1)
    for k in np.argsort(ids):
        u, v = blobs.centroids[k]
        print(
            f'| {ids[k]} | {u:.1f}, {v:.1f} | {2.0 * blobs.radii[k]:.0f} | {TONES[ids[k] - 1]:.0f} '
            f'| {ordered[k, -1] - ordered[k, -2]:.0f} | {residuals[k, 0]:.1f}, {residuals[k, 1]:.1f} |'
        )
    rms = float(np.sqrt(np.mean(residuals**2)))
    print(
        f'\nRoot mean square of the residuals: {rms:.2f} px, {1e3 * rms * HEIGHT / FOCAL:.1f} mm at the lamps.'
    )


def print_pose(fix: BeaconFix) -> None:
    """Print the pose with its deviations."""
    pose, sigmas = fix.T_map_base, 100.0 * np.sqrt(np.diag(fix.covariance)[:3])
    roll, pitch = np.degrees(fix.tilt)
    print(
        f'Pose: x {100.0 * pose.x:.1f} ± {sigmas[0]:.1f} cm, y {100.0 * pose.y:.1f} ± {sigmas[1]:.1f} cm, '
        f'z {100.0 * fix.height:.1f} ± {sigmas[2]:.1f} cm, yaw {np.degrees(pose.yaw):.1f}°, '
        f'tilt {roll:.2f}° and {pitch:.2f}°; the telephone was about under the middle lamp, at z = 0.'
    )


if __name__ == '__main__':
    raise SystemExit(main())
