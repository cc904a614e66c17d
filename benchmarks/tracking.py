"""How many fixes and images a second a tracked robot gets, on one core.

The robot drives 12 mm from image to image (0.36 m/s at 30 images a second) and its odometry is off by 1 %. Rendered
images are made before the clock runs; the times are of `FloorTracker.track` (or `track_dots`, without the image), on
CPU time of this process, which is let onto one core only.
"""

from collections.abc import Callable
from functools import partial
from typing import NamedTuple

import numpy as np
from _figures import mean, measured, rate, time
from _hard_conditions import NEAR_CAMERA, WIDE_CAMERA
from _harness import Option, Run, cpu_time, progress, run_benchmark, use_one_core
from _paper_matchers import detected, indexed
from _paper_views import CAMERA, FLOOR_SIZE, MOUNT, paper_floor, paper_views

from floor_localizer.core.fix import Fix, NoFix
from floor_localizer.core.localizer import FloorLocalizer
from floor_localizer.core.tracker import FloorTracker
from floor_localizer.localization.localizer_from_map_file import compile_kernels
from scene_simulator.floor.camera import PAPER_CAMERA, FloorCamera
from scene_simulator.floor.dot_floor import FloorDesign, generate_dot_floor
from shirube_core.geometry import SE2, PinholeCamera

STEP = 0.012
INTERVAL = 1.0 / 30.0
ODOMETRY_SCALE = 1.01
RIGHT_WITHIN = 0.002
ROUNDS = 3


class Moment(NamedTuple):
    """One image of the drive: the true pose and what finds the pose in it at a stamp."""

    T_map_base: SE2
    track: Callable[[FloorTracker, float], Fix | NoFix]


def moments_of_points(count: int) -> tuple[FloorLocalizer, list[Moment]]:
    """Return the paper's floor and views of 25 % missing and 30 % spurious dots along it."""
    floor = paper_floor(1)
    y = 0.1 + STEP * np.arange(count) % (FLOOR_SIZE[1] - 0.2)
    places = np.column_stack([np.full(count, 0.5 * FLOOR_SIZE[0]), y])
    moments = []
    for view in paper_views(floor, places, 0.25, 0.3, seed=1):
        track = partial(FloorTracker.track_dots, dots=detected(view.pixels), camera=CAMERA)
        moments.append(Moment(view.T_map_view, track))
    return FloorLocalizer(indexed(floor), MOUNT), moments


def moments_of_images(camera: PinholeCamera, count: int) -> tuple[FloorLocalizer, list[Moment]]:
    """Return a rendered floor and images along it."""
    design = FloorDesign(size=(1.2, 1.2), count=round(5384 * 1.2**2))
    floor, photographer = generate_dot_floor(design, 1), FloorCamera(camera)
    rng = np.random.default_rng(2)
    moments = []
    for k in progress(range(count), 'rendering'):
        pose = SE2(0.35 + STEP * k % 0.5, 0.6, 0.1)
        image = photographer.photograph(floor, [pose], rng=rng).image
        moments.append(Moment(pose, partial(FloorTracker.track, image=image, camera=camera)))
    return FloorLocalizer(indexed(floor.points), MOUNT), moments


def main(run: Run, images: int) -> None:
    """Drive along the moments some times."""
    use_one_core()
    compile_kernels()
    few = max(images // 10, 3)
    table = run.table('Tracking', 'from | dots | right | ms: median / 99 % | a second')
    for name, (localizer, moments) in {
        'points, 25 % missing, 30 % spurious': moments_of_points(images),
        'images of 235 x 235': moments_of_images(PAPER_CAMERA, images),
        '1280 x 1024, 0.07 mm a pixel': moments_of_images(NEAR_CAMERA, few),
        '1280 x 1024, 0.38 mm a pixel': moments_of_images(WIDE_CAMERA, few),
    }.items():
        times, right, dots = [], 0, []
        for _ in range(ROUNDS):
            tracker, T_odom_base = FloorTracker(localizer), SE2(0.0, 0.0, 0.0)
            for k, moment in enumerate(moments):
                if k > 0:
                    step = moments[k - 1].T_map_base.inverse() @ moment.T_map_base
                    T_odom_base @= SE2(ODOMETRY_SCALE * step.x, ODOMETRY_SCALE * step.y, step.yaw)
                tracker.add_odometry(k * INTERVAL, T_odom_base)
                found, milliseconds = cpu_time(moment.track, tracker, k * INTERVAL)
                times.append(milliseconds)
                if isinstance(found, Fix):
                    right += found.T_map_base.distance_to(moment.T_map_base) < RIGHT_WITHIN
                dots.append(0 if found.dots is None else len(found.dots))
        rates = (rate(right, len(times)), time(times, '.2f', (50, 99)), measured(1e3 / float(np.mean(times)), '.0f'))
        table.add(name, mean(dots, '.0f', better='higher'), *rates)


if __name__ == '__main__':
    run_benchmark(main, images=Option(200, 40, 'of a drive'))
