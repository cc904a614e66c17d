"""How long a place is looked for in a pair of 1000 segments each: `./shirube bench landmark_speed`.

Scenes: the photographs of ``stereo_euroc/`` (EuRoC V1_01) in the folder that SHIRUBE_DATA names, taught on one pair
and looked for in the other, and rendered corridors. In turn with the whole localizer, ORB and SIFT are detected in
both images and matched. Process time of one process on one core. Run it twice: the first run compiles.
"""

from __future__ import annotations

import argparse
import os
import time
from collections.abc import Callable
from dataclasses import dataclass
from functools import partial
from pathlib import Path

os.environ['OPENBLAS_NUM_THREADS'] = '1'

import cv2
import numpy as np
from _landmark_corridor import TAUGHT, Pair, teach_corridor
from _landmark_photographs import teach_photographs
from _real_pairs import load_real_pairs
from _stage_clock import time_stages
from _timed_answers import use_one_core
from tqdm import tqdm

import stereo_landmark.core.procedure.stereo_view as view_module
import stereo_landmark.core.procedure.target_search as search_module
from scene_simulator.corridor.generator import CorridorDesign, corridor
from scene_simulator.corridor.stereo_rig import StereoRig as Cameras
from scene_simulator.corridor.stereo_rig import render_pair
from shirube_core.geometry import SE2
from stereo_landmark.core.landmark_fix import LandmarkFix, NoLandmarkFix
from stereo_landmark.core.landmark_localizer import LandmarkLocalizer
from stereo_landmark.core.patches.taught_patches import TaughtPatches
from stereo_landmark.core.place.place_locator import PlaceLocator
from stereo_landmark.core.procedure.stereo_view import detect_scene
from stereo_landmark.core.procedure.taught_place import TaughtPlace

WANTED = 100.0
"""[ms]"""
LANDMARKS = ('meter', 'sign', 'cabinet', 'round')
DISPLACEMENT = SE2(0.2, -0.25, 0.1)
STAGES: dict[str, tuple[object, str]] = {
    'edges': (view_module, 'extract_edges'),
    'segments': (view_module, 'trace_segments'),
    'sides': (view_module, 'fit_line_segments'),
    'ellipses': (view_module, 'detect_ellipses'),
    'quadrilaterals': (view_module, 'detect_quadrilaterals'),
    'corners': (view_module, 'detect_corners'),
    'left with right': (view_module, 'match_pairs'),
    'candidates': (search_module, 'find_stereo_candidates'),
    'paths of the tree': (search_module, 'generate_hypotheses'),
    'coarse poses': (search_module, 'fit_coarse_pose'),
    'evidence': (search_module, 'PoseScorer'),
    'measured in grey': (search_module, 'refine_pair'),
    'patches': (TaughtPatches, 'measure'),
    'displacement': (PlaceLocator, 'locate'),
}


@dataclass(frozen=True)
class Case:
    """A place and a pair of images in which it is looked for."""

    name: str
    place: TaughtPlace
    images: Pair
    tilt: tuple[float, float] = (0.0, 0.0)


def cases() -> list[Case]:
    """Return what there is to look for."""
    found = []
    folder = Path(os.environ.get('SHIRUBE_DATA', 'not given')) / 'stereo_euroc'
    if folder.is_dir():
        pairs = load_real_pairs(folder)
        place = teach_photographs(pairs.rig, pairs.moments['teach'], 12, 0)
        now = pairs.moments['repeat']
        found.append(Case('EuRoC V1_01', place, (now.left, now.right), now.tilt))
    for name, tile in (
        ('corridor', 0.0),
        ('corridor, tiles of 0.25 m', 0.25),
        ('corridor, tiles of 0.08 m', 0.08),
    ):
        scene = corridor(CorridorDesign(seed=1))
        taught = teach_corridor(scene, Cameras(), LANDMARKS)
        seen = corridor(CorridorDesign(seed=1, tile=tile, needles=1))
        images = render_pair(seen, taught.cameras, TAUGHT @ DISPLACEMENT, np.random.default_rng(1))
        found.append(Case(name, taught.place, images))
    return found


def features_matched(detector: cv2.Feature2D, norm: int, images: Pair) -> None:
    """Detect features in both images and match them."""
    left, right = (detector.detectAndCompute(image, None)[1] for image in images)
    cv2.BFMatcher(norm).knnMatch(left, right, k=2)


def milliseconds(work: Callable[[], object]) -> float:
    """Return the process time of some work [ms]."""
    begin = time.process_time()
    work()
    return 1e3 * (time.process_time() - begin)


def print_case(case: Case, repeats: int) -> float:
    """Print the table of a case; return the median of the whole [ms]."""
    localizer = LandmarkLocalizer([case.place])
    locate = partial(localizer.locate, *case.images, case.tilt)
    answer = locate()
    peers = {
        'ORB, 2000 features, detected and matched': partial(
            features_matched, cv2.ORB.create(nfeatures=2000), cv2.NORM_HAMMING, case.images
        ),
        'SIFT, 2000 features, detected and matched': partial(
            features_matched, cv2.SIFT.create(nfeatures=2000), cv2.NORM_L2, case.images
        ),
    }
    whole: list[float] = []
    beside: dict[str, list[float]] = {name: [] for name in peers}
    shares: dict[str, list[float]] = {name: [] for name in STAGES}
    for _ in tqdm(range(repeats), case.name, leave=False):
        whole.append(milliseconds(locate))
        with time_stages(STAGES) as spent:
            locate()
        for name in STAGES:
            shares[name].append(spent[name])
        for name, peer in peers.items():
            beside[name].append(milliseconds(peer))
    print(f'\n{case.name}: {described(case, answer)}\n\n| stage | ms: median / 95 % |\n|---|---|')
    for name, times in shares.items():
        print(f'| {name} | {median_and_late(times)} |')
    print(f'| **whole pair** | **{median_and_late(whole)}** |')
    for name, times in beside.items():
        print(f'| peer: {name} | {median_and_late(times)} |')
    return float(np.median(whole))


def described(case: Case, answer: LandmarkFix | NoLandmarkFix) -> str:
    """Return how much there is to see, and what came of it."""
    scenes = [detect_scene(image, case.place.processing, case.place.kinds) for image in case.images]
    seen = ' and '.join(str(len(scene.segments)) for scene in scenes)
    kinds = ', '.join(f'{len(found.primitives)} {kind.value}' for kind, found in scenes[0].kinds.items())
    result = 'found' if isinstance(answer, LandmarkFix) else f'not found ({answer.reason})'
    taught = sum(len(target.primitives) for target in case.place.targets)
    return f'{seen} segments; on the left {kinds}; {taught} primitives taught, {result}.'


def median_and_late(times: list[float]) -> str:
    """Return the median and the 95th percentile."""
    median, late = np.percentile(times, [50.0, 95.0])
    return f'{median:.1f} / {late:.1f}'


def main() -> int:
    """Print the tables; return 1 when a pair takes longer than wanted."""
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument('--repeats', type=int, default=30, help='runs of each scene')
    parser.add_argument('--scenes', type=int, default=4, help='how many of the scenes')
    arguments = parser.parse_args()
    use_one_core()
    medians = [print_case(case, arguments.repeats) for case in cases()[: arguments.scenes]]
    verdict = 'reached' if max(medians) <= WANTED else 'missed'
    print(f'\nAt most {WANTED:.0f} ms a pair: {verdict}, {max(medians):.0f} ms at the most.')
    return 0 if verdict == 'reached' else 1


if __name__ == '__main__':
    raise SystemExit(main())
