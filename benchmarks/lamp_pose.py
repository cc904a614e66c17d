"""Poses from lamps in the paper's room: `./shirube bench lamp_pose`.

Prints the accuracy of the methods with the bound of Cramér and Rao and the coverage of the room, drives with one lamp
and odometry, and the effect of tilt. Rendered images are the matter of `lamp_images`, times of `lamp_speed`.
"""

from __future__ import annotations

import argparse
import math
import os

os.environ['OPENBLAS_NUM_THREADS'] = '1'

import numpy as np
from _lamp_drives import errors_of_drive
from _lamp_methods import METHODS, Locate
from _lamp_report import format_centimetres, format_number
from _lamp_room import BEACONS, CAMERA, IDS, MOUNT, View, cramer_rao_bound, random_views, view_from
from _timed_answers import use_one_core
from tqdm import tqdm

from shirube_core.geometry import SE2
from vlc_beacon.core.pose.beacon_locator import BeaconLocator
from vlc_beacon.core.pose.pose_fix import BeaconFix
from vlc_beacon.core.settings import PoseSettings

NOISES = (0.2, 0.5)
TILTS = (0.0, 0.5, 1.0, 2.0)
IMU_SIGMA = math.radians(0.1)
SECTIONS = ('accuracy', 'drive', 'tilt')


def accuracy(places: int, seed: int) -> None:
    """Print errors against the truth at random places, noise on the centres."""
    views = list(random_views(places, np.random.default_rng(seed)))
    counts = np.array([view.visible.sum() for view in views])
    shares = ', '.join(f'{100.0 * np.mean(counts >= k):.1f} % see {k} or more' for k in (1, 2, 3))
    four = f'{100.0 * np.mean(counts == 4):.1f} % all four'
    print(f'Coverage of {places} places, counting lamps that are wholly in the image: {shares}, {four}.\n')
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
        f'| {name} | {lamps} | {noise} | {len(errors)} of {len(views)} | {format_centimetres(errors)} '
        f'| {format_number(100.0 * rms)} | {compared} |'
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
            f'| {name} | {count} | {100.0 * posed.mean():.1f} | {format_centimetres(errors)} '
            f'| {math.sqrt(np.mean(normalised**2)):.2f} |'
        )


def tilt(count: int, seed: int) -> None:
    """Print errors of a robot that leans, four lamps, 0.2 px of noise."""
    print(
        '| tilt ° | unknown, assumed level | unknown, estimated from the lamps (sigma 1°) | IMU with 0.1° of error |'
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
            pose = SE2(x, y, rng.uniform(-math.pi, math.pi))
            view = view_from(pose, *lean)
            pixels = view.pixels + 0.2 * rng.normal(size=(4, 2))
            measured_tilt = (np.zeros(2), np.zeros(2), lean + IMU_SIGMA * rng.normal(size=2))
            for k, locator in enumerate(locators):
                # The gate would refuse what does not fit; here the error is asked for.
                rays = locator.rays(CAMERA, IDS, pixels, np.full(4, 0.2 if k else 20.0))
                fix = locator.locate(rays, (float(measured_tilt[k][0]), float(measured_tilt[k][1])))
                if isinstance(fix, BeaconFix):
                    errors[k].append(fix.T_map_base.distance_to(pose))
        print(
            f'| {degrees} | '
            + ' | '.join(f'{format_centimetres(each)} ({len(each)})' for each in errors)
            + ' |'
        )


def main() -> int:
    """Print the chosen tables."""
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument('--only', nargs='+', choices=SECTIONS, default=SECTIONS, help='tables to print')
    parser.add_argument('--places', type=int, default=4000, help='places of the accuracy table')
    parser.add_argument('--drives', type=int, default=6, help='drives of each kind')
    parser.add_argument('--seed', type=int, default=1, help='seed of places and noise')
    arguments = parser.parse_args()
    use_one_core()
    sections = {
        'accuracy': lambda: accuracy(arguments.places, arguments.seed),
        'drive': lambda: drives(arguments.drives),
        'tilt': lambda: tilt(300, arguments.seed),
    }
    for name in arguments.only:
        print(f'### {name.capitalize()}\n')
        sections[name]()
        print()
    return 0


if __name__ == '__main__':
    raise SystemExit(main())
