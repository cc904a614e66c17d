"""Depth of two and of three cameras, bad pixels, coverage and time: `./shirube bench trinocular`.

On the Tsukuba images (``SHIRUBE_DATA`` names the folder that holds ``planner/tsukuba``; its cameras stand in a row, so
the third is on the other side) and on rendered pictures of an L of three cameras. Bad are matched pixels whose
disparity is off by more than one pixel. Times are CPU time on one core, OpenCV with one thread.
"""

from __future__ import annotations

import argparse
import os
import time
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path
from typing import NamedTuple

os.environ['OPENBLAS_NUM_THREADS'] = '1'

import cv2
import numpy as np
from _voxel_scenes import CAMERA, ROOM, moving_poses, view_at
from numpy.typing import NDArray
from tqdm import tqdm

from reward_planner.core.depth.depth_settings import DepthSettings
from reward_planner.core.depth.stereo_pair import PairMatcher, StereoPair
from reward_planner.core.depth.trinocular_depth import TrinocularDepth, depth_from_disparity
from scene_simulator.room.cameras import render_picture

Image = NDArray[np.uint8]
BASELINE = 0.1
RIGHT = StereoPair(0, BASELINE, CAMERA.fx, 0.0)
TOP = StereoPair(1, -BASELINE, CAMERA.fy, 0.0)
LEFT = StereoPair(0, -BASELINE, CAMERA.fx, 0.0)
NOISE = 2.0
PLACES = 6
ROUNDS = 15


class Scene(NamedTuple):
    """Three pictures and the true disparity of the first pair, shape (height, width) [px], NaN where not known."""

    left: Image
    right: Image
    third: Image
    disparity: NDArray[np.float64]


def grey_image(path: Path) -> Image:
    """Read an image in grey."""
    image = cv2.imread(str(path), cv2.IMREAD_GRAYSCALE)
    if image is None:
        raise FileNotFoundError(f'{path} is no image')
    return np.asarray(image, dtype=np.uint8)


def tsukuba(folder: Path) -> Scene:
    """Return the real images: the middle one, its right and its left neighbour."""
    middle, right, left, grey = (
        grey_image(folder / name) for name in ('c3.ppm', 'c4.ppm', 'c2.ppm', 'gt.pgm')
    )
    return Scene(middle, right, left, np.where(grey > 0, grey / 16.0, np.nan))


def rendered(place: int) -> Scene:
    """Return what an L of cameras sees at a place of the furnished room."""
    T = view_at(moving_poses(4 * PLACES)[2 * place]).T_map_sensor
    right, top = T.copy(), T.copy()
    right[:3, 3] += BASELINE * T[:3, 0]
    top[:3, 3] -= BASELINE * T[:3, 1]
    rng = np.random.default_rng(place)
    first, second, third = (render_picture(ROOM, CAMERA, view, NOISE, rng) for view in (T, right, top))
    depth = ROOM.depth_image(CAMERA, T).astype(np.float64)
    return Scene(first, second, third, RIGHT.focal_baseline / depth)


def methods(third: StereoPair, settings: DepthSettings) -> dict[str, Callable[[Scene], NDArray[np.float32]]]:
    """Return what gives depth of a scene, by name."""
    pair = PairMatcher(RIGHT, settings)
    agreement = TrinocularDepth(RIGHT, third, replace(settings, fusion='agreement'))
    union = TrinocularDepth(RIGHT, third, replace(settings, fusion='union'))
    return {
        'two cameras': lambda s: depth_from_disparity(pair.match(s.left, s.right), RIGHT),
        'three, agreement': lambda s: agreement.compute(s.left, s.right, s.third).depth,
        'three, union': lambda s: union.compute(s.left, s.right, s.third).depth,
    }


def print_scores(name: str, scenes: list[Scene], third: StereoPair, settings: DepthSettings) -> None:
    """Print coverage and bad pixels of all methods."""
    for method, depth_of in methods(third, settings).items():
        matched = bad = known = 0
        for scene in scenes:
            truth = scene.disparity
            error = np.abs(RIGHT.focal_baseline / depth_of(scene) - truth)
            known += int(np.isfinite(truth).sum())
            matched += int(np.isfinite(error).sum())
            bad += int((error > 1.0).sum())
        shares = f'{matched / known:.3f} | {100.0 * bad / matched:.2f} % | {(matched - bad) / known:.3f}'
        print(f'| {name} | {settings.matcher} | {settings.disparities} | {method} | {shares} |')


def print_times(scene: Scene, settings: DepthSettings) -> None:
    """Print how long one frame takes, all methods in turn."""
    ways = methods(TOP, settings)
    times: dict[str, list[float]] = {name: [] for name in ways}
    for k in tqdm(range(ROUNDS + 1), leave=False):
        for name, depth_of in ways.items():
            start = time.process_time()
            depth_of(scene)
            if k > 0:
                times[name].append(1e3 * (time.process_time() - start))
    for name, taken in times.items():
        median, late = np.percentile(taken, [50.0, 95.0])
        rate = f'{1e3 / median:.1f} | {1e3 / late:.1f}'
        print(
            f'| {settings.matcher} | {settings.disparities} | {name} | {median:.1f} / {late:.1f} | {rate} |'
        )


def main() -> int:
    """Print the tables."""
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.parse_args()
    os.sched_setaffinity(0, {max(os.sched_getaffinity(0))})
    cv2.setNumThreads(1)
    both = [DepthSettings(), DepthSettings(matcher='bm')]
    print('## Two and three cameras\n\n`./shirube bench trinocular`\n')
    print('| pictures | matcher | disparities | cameras | coverage | bad of matched | right of all |')
    print('|---|---|---|---|---|---|---|')
    folder = Path(os.environ.get('SHIRUBE_DATA', 'not given')) / 'planner' / 'tsukuba'
    if folder.is_dir():
        for settings in (*(replace(s, disparities=16) for s in both), DepthSettings()):
            print_scores('Tsukuba, in a row', [tsukuba(folder)], LEFT, settings)
    else:
        print('SHIRUBE_DATA: set it to the folder that holds planner/tsukuba for the real images')
    scenes = [rendered(place) for place in tqdm(range(PLACES), leave=False, desc='rendering')]
    for settings in both:
        print_scores('rendered, in an L', scenes, TOP, settings)
    print('\n| matcher | disparities | cameras, 640 x 480 | ms: median / 95 % | a second: median | 95 % |')
    print('|---|---|---|---|---|---|')
    for settings in both:
        print_times(scenes[0], settings)
    return 0


if __name__ == '__main__':
    raise SystemExit(main())
