"""Poses from lamps in the paper's room: `./shirube bench lamp_pose`.

Prints the accuracy of the methods beside the bound of Cramér and Rao and the coverage of the room, poses from rendered
images, drives with one lamp and odometry, the effect of tilt, and the time of an image on one core.
"""

from __future__ import annotations

import argparse
import math
import os
import time
from typing import NamedTuple

os.environ['OPENBLAS_NUM_THREADS'] = '1'

import cv2
import numpy as np
from _lamp_drives import errors_of_drive
from _lamp_markers import FAMILIES, Markers, is_there
from _lamp_methods import METHODS, Locate
from _lamp_pictures import LIGHTS, Light, picture_of
from _lamp_room import BEACONS, CAMERA, IDS, MOUNT, View, cramer_rao_bound, random_views, view_from
from numpy.typing import NDArray
from tqdm import tqdm

from shirube_geometry import PlanarPose
from vlc_beacon.core.lamp_image.lamp_detector import LampDetector
from vlc_beacon.core.lamp_image.lamp_tracks import LampTracks
from vlc_beacon.core.pose.beacon_locator import BeaconLocator
from vlc_beacon.core.pose.pose_fix import BeaconFix
from vlc_beacon.core.pose.settings import PoseSettings

NOISES = (0.2, 0.5)
TILTS = (0.0, 0.5, 1.0, 2.0)
IMU_SIGMA = math.radians(0.1)
NEAR = 5.0
"""What is found nearer to a lamp is that lamp [px]."""
WARM_UP = 5
"""Images before the clock counts."""
SECTIONS = ('accuracy', 'images', 'drive', 'tilt', 'speed')


class Found(NamedTuple):
    """What was found in an image: ids (n,), centres (n, 2) and sigmas (n,) [px], and how many false ones."""

    ids: NDArray[np.int64]
    centres: NDArray[np.float64]
    sigmas: NDArray[np.float64]
    false: int


def in_centimetres(errors: list[float] | NDArray[np.float64]) -> str:
    """Return median / 95 % / max of errors [m]."""
    if len(errors) == 0:
        return '–'
    return ' / '.join(f'{100.0 * value:.2f}' for value in np.percentile(errors, [50.0, 95.0, 100.0]))


def in_digits(value: float) -> str:
    """Return a number, a dash for NaN."""
    return '–' if math.isnan(value) else f'{value:.3f}'


def accuracy(places: int, seed: int) -> None:
    """Print errors against the truth at random places, noise on the centres."""
    views = list(random_views(places, np.random.default_rng(seed)))
    counts = np.array([view.visible.sum() for view in views])
    shares = ', '.join(f'{100.0 * np.mean(counts >= k):.1f} % see {k} or more' for k in (1, 2, 3))
    print(f'Coverage of {places} places: {shares}, {100.0 * np.mean(counts == 4):.1f} % all four.\n')
    print('| method | lamps | noise px | poses | median / 95 % / max cm | rms cm | bound cm | rms/bound |')
    print('|---|---|---|---|---|---|---|---|')
    for name, least, locate, height_known in tqdm(METHODS, leave=False):
        chosen = [view for view, count in zip(views, counts, strict=True) if count >= least]
        for noise in NOISES:
            tqdm.write(row_of_accuracy(name, least, locate, height_known, chosen, noise))


def row_of_accuracy(
    name: str, least: int, locate: Locate, height_known: bool | None, views: list[View], noise: float
) -> str:
    """Return a line of the table."""
    rng = np.random.default_rng(7)
    errors, bounds = [], []
    for view in views:
        found = locate(view, view.pixels + noise * rng.normal(size=(4, 2)), noise)
        if found is None:
            continue
        errors.append(math.hypot(found[0] - view.pose.x, found[1] - view.pose.y))
        if height_known is not None:
            bounds.append(cramer_rao_bound(view, noise, height_known=height_known))
    rms = math.sqrt(np.mean(np.square(errors))) if errors else math.nan
    bound = math.sqrt(np.mean(bounds)) if bounds else math.nan
    compared = f'{100.0 * bound:.3f} | {rms / bound:.3f}' if bounds else '– | –'
    lamps = '4' if least == 4 else f'{least}-4'
    return (
        f'| {name} | {lamps} | {noise} | {len(errors)} of {len(views)} | {in_centimetres(errors)} '
        f'| {in_digits(100.0 * rms)} | {compared} |'
    )


def images(count: int, seed: int) -> None:
    """Print errors of poses from rendered images, of lamps and of markers."""
    families = FAMILIES if is_there() else ()
    if not families:
        print('OpenCV 4.7 or later would show markers beside the lamps.\n')
    print('| light | what | in view | found | false | centre rms px | poses | median / 95 % / max cm |')
    print('|---|---|---|---|---|---|---|---|')
    finders: list[tuple[str, LampFinder | MarkerFinder]] = [('lamps', LampFinder())]
    finders += [(name, MarkerFinder(name)) for name in families]
    for light in tqdm(LIGHTS, leave=False):
        for what, finder in finders:
            tqdm.write(row_of_images(light, what, finder, count, seed))


class LampFinder:
    """Finds lamps in an image of a view; which is which is taken from the truth, since nothing is played here."""

    def __init__(self) -> None:
        """Make a detector."""
        self._detector = LampDetector()

    def find(self, view: View, light: Light, rng: np.random.Generator) -> Found:
        """Return what is found."""
        blobs = self._detector.detect(picture_of(view.pixels[view.visible], light, rng))
        distances = np.hypot(*(blobs.centroids[:, None] - view.pixels[None]).transpose(2, 0, 1))
        near = distances.min(axis=1) < NEAR
        ids = IDS[distances.argmin(axis=1)][near]
        return Found(ids, blobs.centroids[near], blobs.sigmas[near].max(axis=1), int((~near).sum()))


class MarkerFinder:
    """Finds printed markers in the lamps' places."""

    def __init__(self, family: str) -> None:
        """Take the family's name."""
        self._markers = Markers(family, sensitive=True)

    def find(self, view: View, light: Light, rng: np.random.Generator) -> Found:
        """Return what is found."""
        found = self._markers.find(self._markers.picture(view, light, rng))
        offsets = found.centres - view.pixels[found.ids - 1]
        near = np.hypot(offsets[:, 0], offsets[:, 1]) < NEAR
        false = found.others + int((~near).sum())
        return Found(found.ids[near], found.centres[near], np.full(int(near.sum()), 0.2), false)


def row_of_images(light: Light, what: str, finder: LampFinder | MarkerFinder, count: int, seed: int) -> str:
    """Return a line of the table: places that see two lamps or more."""
    rng = np.random.default_rng(seed)
    locator = BeaconLocator(BEACONS, MOUNT)
    views = [view for view in random_views(3 * count, rng) if view.visible.sum() >= 2][:count]
    shown, offsets, errors, false = 0, [np.empty((0, 2))], [], 0
    for view in tqdm(views, leave=False):
        found = finder.find(view, light, rng)
        shown, false = shown + int(view.visible.sum()), false + found.false
        offsets.append(found.centres - view.pixels[found.ids - 1])
        fix = locator.locate(locator.rays(CAMERA, found.ids, found.centres, found.sigmas))
        if isinstance(fix, BeaconFix):
            errors.append(fix.T_map_base.distance_to(view.pose))
    together = np.concatenate(offsets)
    rms = math.sqrt(np.mean(together**2)) if len(together) else math.nan
    return (
        f'| {light.name} | {what} | {shown} | {len(together)} | {false} | {in_digits(rms)} '
        f'| {len(errors)} of {len(views)} | {in_centimetres(errors)} |'
    )


def drives(count: int) -> None:
    """Print errors along drives of 30 s, 0.2 px of noise, odometry off by 2 % and 0.2 degrees a metre."""
    print(
        '| lamps after the first second | drives | images with a pose % | median / 95 % / max cm | rms error/sigma |'
    )
    print('|---|---|---|---|---|')
    rules = (('all', 'all in view'), ('one', 'one'), ('gaps', 'none for 3 s, one for 3 s, in turn'))
    for rule, name in tqdm(rules, leave=False):
        rows = np.array(
            [row for seed in tqdm(range(count), leave=False) for row in errors_of_drive(rule, 0.2, seed)]
        )
        posed = np.isfinite(rows[:, 0])
        errors, normalised = rows[posed].T
        tqdm.write(
            f'| {name} | {count} | {100.0 * posed.mean():.1f} | {in_centimetres(errors)} '
            f'| {math.sqrt(np.mean(normalised**2)):.2f} |'
        )


def tilt(count: int, seed: int) -> None:
    """Print errors of a robot that leans, four lamps, 0.2 px of noise."""
    print(
        '| tilt ° | unknown, taken for level | unknown, found by the lamps (sigma 1°) | IMU with 0.1° of error |'
    )
    print('|---|---|---|---|')
    locators = [
        BeaconLocator(BEACONS, MOUNT, None, PoseSettings(pixel_sigma=0.0, beacon_sigma=0.0, tilt_sigma=sigma))
        for sigma in (0.0, math.radians(1.0), IMU_SIGMA)
    ]
    for degrees in TILTS:
        rng = np.random.default_rng(seed)
        errors: list[list[float]] = [[], [], []]
        for _ in range(count):
            course, (x, y) = rng.uniform(-math.pi, math.pi), rng.uniform(0.6, 1.2, 2)
            lean = math.radians(degrees) * np.array([math.cos(course), math.sin(course)])
            pose = PlanarPose(x, y, rng.uniform(-math.pi, math.pi))
            view = view_from(pose, *lean)
            pixels = view.pixels + 0.2 * rng.normal(size=(4, 2))
            told = (np.zeros(2), np.zeros(2), lean + IMU_SIGMA * rng.normal(size=2))
            for k, locator in enumerate(locators):
                # The gate would refuse what does not fit; here the error is asked for.
                rays = locator.rays(CAMERA, IDS, pixels, np.full(4, 0.2 if k else 20.0))
                fix = locator.locate(rays, (float(told[k][0]), float(told[k][1])))
                if isinstance(fix, BeaconFix):
                    errors[k].append(fix.T_map_base.distance_to(pose))
        print(
            f'| {degrees} | ' + ' | '.join(f'{in_centimetres(each)} ({len(each)})' for each in errors) + ' |'
        )


def speed(count: int, seed: int) -> None:
    """Print the time of an image of 1280 x 1024 with four lamps, and of finding four markers, in turn."""
    print(
        '| light | detect ms | follow ms | pose ms | all ms: median / 95 % | images a second | ArUco detect ms |'
    )
    print('|---|---|---|---|---|---|---|')
    for light in tqdm(LIGHTS, leave=False):
        tqdm.write(row_of_speed(light, count, seed))


def row_of_speed(light: Light, count: int, seed: int) -> str:
    """Return a line of the table."""
    rng = np.random.default_rng(seed)
    view = view_from(PlanarPose(0.95, 0.85, 0.4))
    detector, tracks, locator = LampDetector(), LampTracks(), BeaconLocator(BEACONS, MOUNT)
    pictures = [picture_of(view.pixels, light, rng) for _ in range(4)]
    markers = Markers('ArUco 4x4', sensitive=False) if is_there() else None
    marked = markers.picture(view, light, rng) if markers else None
    times, peer = [], [math.nan]
    for k in range(count + WARM_UP):
        picture, start = pictures[k % 4], time.process_time()
        blobs = detector.detect(picture)
        detected = time.process_time()
        lit = [sample for sample in tracks.update(k / 60.0, picture, blobs) if sample.is_lit]
        followed = time.process_time()
        ids = [int(IDS[np.hypot(*(view.pixels - sample.centre).T).argmin()]) for sample in lit]
        sigmas = [float(sample.sigma.max()) for sample in lit]
        locator.locate(locator.rays(CAMERA, ids, [sample.centre for sample in lit], sigmas))
        end = time.process_time()
        times.append((detected - start, followed - detected, end - followed, end - start))
        if markers and marked is not None:
            markers.find(marked)
            peer.append(time.process_time() - end)
    spent = 1e3 * np.array(times[WARM_UP:])
    parts = ' | '.join(f'{value:.2f}' for value in np.median(spent[:, :3], axis=0))
    median, late = np.percentile(spent[:, 3], [50.0, 95.0])
    aruco = 1e3 * float(np.nanmedian(peer[-count:]))
    return f'| {light.name} | {parts} | {median:.2f} / {late:.2f} | {1e3 / spent[:, 3].mean():.0f} | {aruco:.2f} |'


def main() -> int:
    """Print the chosen tables."""
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument('--only', nargs='+', choices=SECTIONS, default=SECTIONS, help='tables to print')
    parser.add_argument('--places', type=int, default=4000, help='places of the accuracy table')
    parser.add_argument('--images', type=int, default=100, help='images of each light')
    parser.add_argument('--drives', type=int, default=6, help='drives of each kind')
    parser.add_argument('--seed', type=int, default=1, help='seed of places and noise')
    arguments = parser.parse_args()
    os.sched_setaffinity(0, {max(os.sched_getaffinity(0))})
    cv2.setNumThreads(1)
    sections = {
        'accuracy': lambda: accuracy(arguments.places, arguments.seed),
        'images': lambda: images(arguments.images, arguments.seed),
        'drive': lambda: drives(arguments.drives),
        'tilt': lambda: tilt(300, arguments.seed),
        'speed': lambda: speed(arguments.images, arguments.seed),
    }
    for name in arguments.only:
        print(f'### {name.capitalize()}\n')
        sections[name]()
        print()
    return 0


if __name__ == '__main__':
    raise SystemExit(main())
