"""How many fixes and images a second a tracked robot gets, on one core: `./shirube bench tracking`.

The robot drives 12 mm from image to image (0.36 m/s at 30 images a second) and its odometry is off by 1 %. Rendered
images are made before the clock runs; the times are of `FloorTracker.track` (or `track_dots`, without the image), on
CPU time of this process, which is let onto one core only.
"""

from __future__ import annotations

import argparse
import os
import time
from collections.abc import Callable
from functools import partial
from typing import NamedTuple

os.environ['OPENBLAS_NUM_THREADS'] = '1'

import cv2
import numpy as np
from _dot_conditions import NEAR_CAMERA, WIDE_CAMERA
from _paper_matchers import DOT_DIAMETER
from _paper_views import CAMERA, FLOOR_SIZE, MOUNT, NOISE, paper_floor, paper_views
from numpy.typing import NDArray
from tqdm import tqdm

from floor_localizer.core.compile_kernels import compile_kernels
from floor_localizer.core.constellation.indexed_map import index_map
from floor_localizer.core.dots import DetectedDots, DotMap
from floor_localizer.core.fix import Fix, NoFix
from floor_localizer.core.localizer import FloorLocalizer
from floor_localizer.core.tracker import FloorTracker
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


def track_dots(dots: DetectedDots, tracker: FloorTracker, stamp: float) -> Fix | NoFix:
    """Find the pose from dots."""
    return tracker.track_dots(stamp, dots, CAMERA)


def track_image(
    image: NDArray[np.uint8], camera: PinholeCamera, tracker: FloorTracker, stamp: float
) -> Fix | NoFix:
    """Find the pose in an image."""
    return tracker.track(stamp, image, camera)


def moments_of_points(count: int) -> tuple[FloorLocalizer, list[Moment]]:
    """Return the paper's floor and views of 25 % missing and 30 % spurious dots along it."""
    floor = paper_floor(1)
    y = 0.1 + STEP * np.arange(count) % (FLOOR_SIZE[1] - 0.2)
    places = np.column_stack([np.full(count, 0.5 * FLOOR_SIZE[0]), y])
    moments = []
    for view in paper_views(floor, places, 0.25, 0.3, seed=1):
        diameters = np.full(len(view.pixels), DOT_DIAMETER / MOUNT.xyz[2] * CAMERA.fx)
        dots = DetectedDots(view.pixels, diameters, np.full(len(view.pixels), NOISE))
        moments.append(Moment(view.T_map_view, partial(track_dots, dots)))
    return localizer_on(floor), moments


def moments_of_images(camera: PinholeCamera, count: int) -> tuple[FloorLocalizer, list[Moment]]:
    """Return a rendered floor and images along it."""
    design = FloorDesign(size=(1.2, 1.2), count=round(5384 * 1.2**2))
    floor, photographer = generate_dot_floor(design, 1), FloorCamera(camera)
    rng = np.random.default_rng(2)
    moments = []
    for k in tqdm(range(count), desc='rendering', leave=False):
        pose = SE2(0.35 + STEP * k % 0.5, 0.6, 0.1)
        image = photographer.photograph(floor, [pose], rng=rng).image
        moments.append(Moment(pose, partial(track_image, image, camera)))
    return localizer_on(floor.points), moments


def localizer_on(floor: NDArray[np.float64]) -> FloorLocalizer:
    """Return a localizer with the defaults on a floor, shape (N, 2) [m]."""
    return FloorLocalizer(index_map(DotMap(floor, np.full(len(floor), np.nan))), MOUNT)


def row_of(name: str, localizer: FloorLocalizer, moments: list[Moment]) -> str:
    """Drive along the moments some times and return a line of the table."""
    times, right, dots = [], 0, []
    for _ in range(ROUNDS):
        tracker, T_odom_base = FloorTracker(localizer), SE2(0.0, 0.0, 0.0)
        for k, moment in enumerate(moments):
            if k > 0:
                step = moments[k - 1].T_map_base.inverse() @ moment.T_map_base
                T_odom_base = T_odom_base @ SE2(ODOMETRY_SCALE * step.x, ODOMETRY_SCALE * step.y, step.yaw)
            tracker.add_odometry(k * INTERVAL, T_odom_base)
            start = time.process_time()
            found = moment.track(tracker, k * INTERVAL)
            times.append(1e3 * (time.process_time() - start))
            right += isinstance(found, Fix) and found.T_map_base.distance_to(moment.T_map_base) < RIGHT_WITHIN
            dots.append(0 if found.dots is None else len(found.dots))
    median, late = np.percentile(times, [50.0, 99.0])
    return (
        f'| {name} | {np.mean(dots):.0f} | {right} of {len(times)} | {median:.2f} | {late:.2f} | '
        f'{1e3 / np.mean(times):.0f} |'
    )


def main() -> None:
    """Print the table."""
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument('--images', type=int, default=200, help='images of a drive')
    arguments = parser.parse_args()
    os.sched_setaffinity(0, {max(os.sched_getaffinity(0))})
    cv2.setNumThreads(1)
    compile_kernels()
    few = max(arguments.images // 10, 3)
    print('| from | dots | right | median ms | 99 % ms | a second |\n|---|---|---|---|---|---|')
    print(row_of('points, 25 % missing, 30 % spurious', *moments_of_points(arguments.images)))
    print(row_of('images of 235 x 235', *moments_of_images(PAPER_CAMERA, arguments.images)))
    print(row_of('1280 x 1024, 0.07 mm a pixel', *moments_of_images(NEAR_CAMERA, few)))
    print(row_of('1280 x 1024, 0.38 mm a pixel', *moments_of_images(WIDE_CAMERA, few)))


if __name__ == '__main__':
    main()
