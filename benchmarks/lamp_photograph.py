"""Real photographs: coded lamps among other lights, a pose; people, rooms and furniture that are no lamps.

The lamps are Luxapose's (SHIRUBE_DATA, ``vlc_luxapose/``, ``vlc_luxapose_more/``): a telephone with a rolling shutter,
tones of 2 to 5 kHz, known places. The people and rooms are any pictures in ``people_rooms/``, and the stereo pairs.
"""

import math
from dataclasses import dataclass
from functools import cached_property
from pathlib import Path

import cv2
import numpy as np
import yaml
from _figures import count, error, rate, rms
from _harness import Option, Run, progress, run_benchmark, use_one_core
from _lamp_commands import lamps_that_say
from _lamp_films import BEACONS as RENDERED
from _lamp_films import RS_FSK_30, UFSOOK, Channel
from numpy.typing import NDArray

from scene_simulator.ceiling.camera import UPWARD_MOUNT, CeilingCamera
from scene_simulator.imaging.exposure import camera_pose
from shirube_core.geometry import SE2, CameraMount, PinholeCamera
from vlc_beacon.core.lamp_image.blob_measurement import LampBlobs
from vlc_beacon.core.lamp_image.lamp_detector import LampDetector, noise_sigma
from vlc_beacon.core.lamp_image.row_profile import LampRows, row_profile, rows_from_frame
from vlc_beacon.core.light_code.rs_fsk import ToneDecoder, tone_log_likelihoods
from vlc_beacon.core.pose.beacon_locator import BeaconLocator
from vlc_beacon.core.pose.lamp_rays import Beacon, LampRays
from vlc_beacon.core.pose.pose_fix import BeaconFix, NoBeaconFix
from vlc_beacon.core.receiver.lamp_decoder import band_rows
from vlc_beacon.core.receiver.light_receiver import LightReceiver
from vlc_beacon.core.settings import LampSettings, PoseSettings

FOCAL, ROWS_A_SECOND, EXPOSURE, LONGEST_STRIPE = 5620.0, 47540.0, 5e-5, 20.0
"""Of the telephone [px, 1/s, s], and of the slowest lamp in it [px]."""
TONES = (2000.0, 2500.0, 3000.0, 3500.0, 4000.0)  # [Hz]
HEIGHT = 2.46
# The plan is drawn as one sees it from below: x of a map with z up is the other way.
PLAN = ((35.56, 36.83), (-35.56, 36.83), (-35.56, -36.83), (35.56, -36.83), (0.0, 0.0))
"""Of the lamps, in the order of their tones [cm]."""
BEACONS = [Beacon(k + 1, (x / 100.0, y / 100.0, HEIGHT), 0.02) for k, (x, y) in enumerate(PLAN)]
LEVEL = CameraMount((0.0, 0.0, 0.0), (0.0, 0.0, 0.0))
# A telephone is about level, and its lens is not calibrated.
SETTINGS = PoseSettings(pixel_sigma=3.0, beacon_sigma=0.0, tilt_sigma=0.05)
DETECTOR = LampDetector(LampSettings(contrast_min=10.0, stripe_rows=LONGEST_STRIPE))
NEAR = 10.0  # what is found nearer to a lamp is that lamp [px]
AMBIENT = 0.35  # level of white in the pictures that rendered lamps of level 0.9 shine over


@dataclass
class Photograph:
    """Lamps of a photograph, and the log likelihoods of `TONES`, shape (lamps, tones)."""

    grey: NDArray[np.uint8]
    blobs: LampBlobs

    @cached_property
    def rows(self) -> list[LampRows]:
        """Rows of each lamp."""
        noise, rows, blobs = noise_sigma(self.grey), [], self.blobs
        for centre, radius, background in zip(blobs.centroids, blobs.radii, blobs.backgrounds, strict=True):
            first, brightness = row_profile(self.grey, centre, radius, background, noise)
            rows.append(rows_from_frame(0.0, first, brightness, 1.0 / ROWS_A_SECOND, EXPOSURE))
        return rows

    @cached_property
    def played(self) -> NDArray[np.float64]:
        """Log likelihoods of `TONES`, shape (lamps, tones)."""
        return np.array([tone_log_likelihoods(rows, TONES)[0] for rows in self.rows])

    def locate(self) -> tuple[LampRays, BeaconFix | NoBeaconFix]:
        """Return rays and pose by `BEACONS`."""
        height, width = self.grey.shape
        camera = PinholeCamera(width, height, FOCAL, FOCAL, 0.5 * (width - 1), 0.5 * (height - 1))
        locator, ids = BeaconLocator(BEACONS, LEVEL, None, SETTINGS), 1 + self.played.argmax(axis=1)
        rays = locator.rays(camera, ids, self.blobs.centroids, self.blobs.sigmas.max(axis=1))
        return rays, locator.locate(rays)


def read_photograph(path: Path, *, is_upright: bool = True) -> Photograph:
    """Return a photograph with its lamps; one that is not upright is turned to the left first, as it is stored."""
    flags = cv2.IMREAD_GRAYSCALE | (0 if is_upright else cv2.IMREAD_IGNORE_ORIENTATION)
    image = cv2.imread(str(path), flags)
    grey = np.asarray(image if is_upright else cv2.rotate(image, cv2.ROTATE_90_COUNTERCLOCKWISE), np.uint8)
    return Photograph(grey, DETECTOR.detect(grey))


def names_in_photographs(folder: Path) -> list[tuple[str, int, int, int, list[int | None]]]:
    """Return of each photograph: name, number of lamps, found and named rightly, and the names of other lights."""
    found = []
    for reference in yaml.safe_load((folder / 'reference.yaml').read_text())['photographs']:
        photograph, seen = read_photograph(folder / reference['image'], is_upright=False), reference['seen']
        tones = {lamp['id']: lamp['frequency'] for lamp in reference['lamps']}
        names = [ToneDecoder(tones).add_frames(rows) for rows in photograph.rows]
        offsets = photograph.blobs.centroids[:, None] - np.array([lamp['uv'] for lamp in seen])
        near = np.hypot(*offsets.transpose(2, 0, 1)) < NEAR
        right = sum(names[k] == seen[i]['id'] for k, i in np.argwhere(near))
        others = [name for name, is_lamp in zip(names, near.any(axis=1), strict=True) if not is_lamp]
        found.append((reference['image'], len(seen), int(near.any(axis=0).sum()), right, others))
    return found


def film_over(picture: NDArray[np.uint8], channel: Channel, seconds: float) -> tuple[int, int, int]:
    """Return how many of four rendered lamps over a picture that moves are named, displaced, and how many IDs wrong.

    A lamp is displaced if something bright of the picture belongs to its blob.
    """
    height, width = picture.shape
    focal = 0.8 * 0.5 * min(height, width) / 0.9 * 2.5
    camera = PinholeCamera(width, height, focal, focal, 0.5 * (width - 1), 0.5 * (height - 1))
    eye, rng = CeilingCamera(camera, channel.shutter), np.random.default_rng(0)
    room = lamps_that_say({}, channel, eye, rng.uniform(0.0, 9.0, 4).tolist())
    receiver, pose = LightReceiver(RENDERED, channel.settings), camera_pose(SE2(0.9, 0.9, 0.0), UPWARD_MOUNT)
    true = camera.pixels_from_points(pose.camera_points([beacon.xyz for beacon in RENDERED]))
    named, displaced, wrong = set[int](), set[int](), set[int]()
    for stamp in (np.arange(round(seconds * channel.rate)) / channel.rate).tolist():
        light = eye.light(room, lambda _: pose, stamp)
        light += AMBIENT / 255.0 * np.roll(picture, round(30.0 * stamp), axis=1)
        for lamp in receiver.receive(stamp, eye.sensor.expose(light, rng)):
            off = math.inf
            if lamp.beacon is not None:
                off = float(np.hypot(*(lamp.sample.centre - true[lamp.beacon - 1])))
            if lamp.beacon is not None and off < NEAR + lamp.sample.radius:
                (named if off < NEAR else displaced).add(lamp.beacon)
            elif lamp.beacon is not None or lamp.unknown_id is not None or lamp.commands or lamp.message:
                wrong.add(lamp.sample.key)
    return len(named), len(displaced), len(wrong)


def add_people(run: Run, pictures: int, seconds: float) -> None:
    """Add false detections in pictures without lamps, and names where rendered lamps shine over them."""
    folders = [run.data() / name for name in ('people_rooms', 'stereo_euroc', 'stereo_machine_hall')]
    paths = [path for folder in folders for path in sorted(folder.rglob('*')) if path.suffix in ('.jpg', '.png')]
    chosen = [paths[i] for i in np.linspace(0, len(paths) - 1, min(pictures, len(paths))).astype(int)]
    heads = ('pictures', 'blobs a picture: median / 95 % / max', 'rendered lamps named', 'displaced', 'wrong IDs')
    table = run.table('People and rooms', 'camera', *heads)
    for channel in (UFSOOK, RS_FSK_30):
        rows = band_rows(channel.settings, ()) if channel.settings.is_rolling else 0.0
        detector, blobs, counts = LampDetector(LampSettings(stripe_rows=rows)), [], np.zeros(3, dtype=int)
        for path in progress(chosen, channel.name):
            picture = np.asarray(cv2.imread(str(path), cv2.IMREAD_GRAYSCALE), np.uint8)
            blobs.append(len(detector.detect(picture)))
            counts += film_over(picture, channel, seconds)
        named, displaced, wrong = (int(each) for each in counts)
        table.add(
            *(channel.name, str(len(chosen)), error(np.array(blobs), '.0f')),
            *(rate(named, 4 * len(chosen)), count(displaced), count(wrong, better='lower')),
        )


def add_pose(run: Run) -> None:
    """Add the five lamps of a photograph and its pose."""
    path = run.data('vlc_luxapose', 'x_0_y_1.27.jpg')
    photograph = read_photograph(path)
    blobs, ordered = photograph.blobs, np.sort(photograph.played, axis=1)
    rays, fix = photograph.locate()
    if not isinstance(fix, BeaconFix):
        run.note(f'No pose: {fix}')
        return
    residuals = fix.residuals * np.hypot(rays.sigmas, SETTINGS.pixel_sigma)[:, None]
    heads: tuple[str, ...] = ('frequency Hz', 'diameter px', 'ahead of the next by (log likelihood)')
    table = run.table('Lamps', 'lamp', *heads, 'residual px: rms')
    for k in np.argsort(rays.ids):
        ahead = count(ordered[k, -1] - ordered[k, -2], '.0f', better='higher')
        table.add(
            *(str(rays.ids[k]), f'{TONES[rays.ids[k] - 1]:.0f}', count(2.0 * blobs.radii[k], '.0f')),
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


def main(run: Run, pictures: int, seconds: float) -> None:
    """Find the lamps and the pose, and what is no lamp."""
    use_one_core()
    heads = 'lamps found', 'named', 'other lights found', 'of them named'
    table = run.table('Lamps among other lights', 'photograph', *heads)
    for name, lamps, found, right, others in names_in_photographs(run.data('vlc_luxapose_more')):
        named = count(sum(other is not None for other in others), better='lower')
        table.add(name, rate(found, lamps), rate(right, lamps), count(len(others)), named)
    add_people(run, pictures, seconds)
    add_pose(run)


if __name__ == '__main__':
    run_benchmark(
        main, pictures=Option(12, 2, 'without lamps, at most'), seconds=Option(4.0, 3.0, 'of lamps rendered over each')
    )
