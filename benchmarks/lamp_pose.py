"""Poses from lamps in the paper's room: accuracy of the methods with the Cramér-Rao bound, drives with one lamp, tilt.

Rendered images are the matter of `lamp_images`, times of `lamp_speed`.
"""

import math

import numpy as np
from _figures import error, rate, rms
from _harness import Option, Run, progress, run_benchmark, use_one_core
from _lamp_drives import errors_of_drive
from _lamp_methods import METHODS
from _lamp_room import BEACONS, CAMERA, IDS, MOUNT, WIDE, cramer_rao_bound, random_views, view_from

from shirube_core.geometry import SE2
from vlc_beacon.core.pose.beacon_locator import BeaconLocator
from vlc_beacon.core.pose.pose_fix import BeaconFix
from vlc_beacon.core.settings import PoseSettings

NOISES = (0.2, 0.5)
TILTS = (0.0, 0.5, 1.0, 2.0)
IMU_SIGMA = math.radians(0.1)
RULES = {'all': 'all in view', 'one': 'one', 'gaps': 'none for 3 s, one for 3 s, in turn'}


def add_accuracy(run: Run, places: int) -> None:
    """Add errors against the truth at random places, noise on the centres."""
    for name, camera in (('of this camera', CAMERA), ("with the paper's angles, 105.9 x 77.8 degrees", WIDE)):
        views = list(random_views(places, np.random.default_rng(run.seed), camera))
        counts = np.array([view.visible.sum() for view in views])
        shares = ', '.join(f'{100.0 * np.mean(counts >= k):.1f} % see {k} or more' for k in (1, 2, 3, 4))
        run.note(f'Coverage {name} at {places} places, counting lamps wholly in the image: {shares}.')
    views = list(random_views(places, np.random.default_rng(run.seed)))
    counts = np.array([view.visible.sum() for view in views])
    heads = 'method', 'lamps', 'noise px', 'poses', 'cm: median / 95 % / max'
    table = run.table('Accuracy', *heads, 'rms cm', 'rms over the bound')
    for name, least, locate, height_known in progress(METHODS):
        chosen = [view for view, count in zip(views, counts, strict=True) if count >= least]
        for noise in NOISES:
            rng, errors, bounds = np.random.default_rng(7), [], []
            for view in chosen:
                found = locate(view, view.pixels + noise * rng.normal(size=(4, 2)), noise)
                if found is not None:
                    errors.append(math.hypot(found[0] - view.pose.x, found[1] - view.pose.y))
                    if height_known is not None:
                        bounds.append(cramer_rao_bound(view, noise, height_known=height_known))
            lamps = '4' if least == 4 else f'{least}-4'
            table.add(
                *(name, lamps, str(noise), rate(len(errors), len(chosen))),
                *(error(errors, '.2f', 100.0), rms(errors, scale=100.0)),
                rms(np.array(errors) / math.sqrt(np.mean(bounds)), better='one') if bounds else '–',
            )


def add_drives(run: Run, drives: int) -> None:
    """Add errors along drives of 30 s, 0.2 px of noise, odometry off by 2 % and 0.2 degrees a metre."""
    heads = ('lamps after the first second', 'images with a pose', 'cm: median / 95 % / max', 'error / sigma: rms')
    table = run.table('One lamp and odometry', *heads)
    for rule, name in RULES.items():
        found = np.array([row for seed in progress(range(drives), name) for row in errors_of_drive(rule, 0.2, seed)])
        posed = np.isfinite(found[:, 0])
        table.add(
            *(name, rate(int(posed.sum()), len(posed)), error(found[:, 0], '.2f', 100.0)), rms(found[:, 1], '.2f')
        )


def add_tilt(run: Run, places: int) -> None:
    """Add errors of a robot that leans, four lamps, 0.2 px of noise."""
    ways = 'assumed level', 'estimated from the lamps (sigma 1°)', 'IMU with 0.1° of error'
    table = run.table('Tilt', 'tilt °', *(f'{way}: cm, median / 95 % / max' for way in ways))
    locators = [
        BeaconLocator(BEACONS, MOUNT, None, PoseSettings(pixel_sigma=0.0, beacon_sigma=0.0, tilt_sigma=sigma))
        for sigma in (0.0, math.radians(1.0), IMU_SIGMA)
    ]
    for degrees in TILTS:
        rng, errors = np.random.default_rng(run.seed), [list[float]() for _ in locators]
        for _ in range(places):
            course, (x, y) = rng.uniform(-math.pi, math.pi), rng.uniform(0.6, 1.2, 2)
            lean = math.radians(degrees) * np.array([math.cos(course), math.sin(course)])
            pose = SE2(x, y, rng.uniform(-math.pi, math.pi))
            pixels = view_from(pose, *lean).pixels + 0.2 * rng.normal(size=(4, 2))
            measured_tilt = (np.zeros(2), np.zeros(2), lean + IMU_SIGMA * rng.normal(size=2))
            for k, locator in enumerate(locators):
                # The gate would refuse what does not fit; here the error is asked for.
                rays = locator.rays(CAMERA, IDS, pixels, np.full(4, 0.2 if k else 20.0))
                fix = locator.locate(rays, (float(measured_tilt[k][0]), float(measured_tilt[k][1])))
                if isinstance(fix, BeaconFix):
                    errors[k].append(fix.T_map_base.distance_to(pose))
        table.add(str(degrees), *(error(each, '.2f', 100.0) for each in errors))


def main(run: Run, places: int, drives: int, leaning: int) -> None:
    """Measure the errors."""
    use_one_core()
    add_accuracy(run, places)
    add_drives(run, drives)
    add_tilt(run, leaning)


if __name__ == '__main__':
    run_benchmark(
        main,
        places=Option(4000, 300, 'of the accuracy table'),
        drives=Option(4, 1, 'of each kind'),
        leaning=Option(300, 40, 'places of each tilt'),
    )
