"""How long a place is looked for in a pair of 1000 segments each, beside ORB and SIFT.

Scenes: EuRoC V1_01 (SHIRUBE_DATA, ``stereo_euroc/``), taught on one pair and looked for in the other, and rendered
corridors. In turn with the whole localizer, ORB and SIFT are detected in both images and matched. Process time of one
process on one core.
"""

from collections.abc import Iterator
from functools import partial
from typing import NamedTuple

import cv2
import numpy as np
from _figures import ratio, time
from _harness import MissingError, Option, Run, run_benchmark, side_by_side, use_one_core
from _landmark_corridor import TAUGHT, teach_corridor
from _real_pairs import load_real_pairs
from _stereo_peers import FeaturePipeline
from _stereo_scenes import RIG, Pair
from _target_choice import TargetChooser

from scene_simulator.corridor.generator import CorridorDesign, corridor
from scene_simulator.corridor.stereo_rig import render_pair
from shirube_core.geometry import SE2
from stereo_landmark.core.landmark_localizer import LandmarkFix, LandmarkLocalizer, PlacePrior
from stereo_landmark.core.procedure.stereo_view import detect_scene
from stereo_landmark.core.procedure.taught_place import TaughtPlace
from stereo_landmark.core.settings import PAPER, LandmarkSettings
from stereo_landmark.core.view_localizer import state_of

DISPLACEMENT = SE2(0.2, -0.25, 0.1)
TILES = (0.0, 0.25, 0.08)  # of the corridors' walls [m]
OFF = np.array([0.004, 0.004, 0.0, 0.002, 0.0, 0.0])  # error of the predicted pose: x, y, z [m], yaw, roll, pitch [rad]
THRESHOLD = 3.31  # with which each photograph has nearly 1000 segments [grey levels / px]


class Case(NamedTuple):
    """A place and a pair of images in which it is looked for."""

    name: str
    place: TaughtPlace
    images: Pair
    taught: Pair
    tilt: tuple[float, float] = (0.0, 0.0)


def cases(run: Run, tiles: tuple[float, ...]) -> Iterator[Case]:
    """Yield what there is to look for."""
    try:
        pairs = load_real_pairs(run.data('stereo_euroc'))
        then, now = pairs.moments['teach'], pairs.moments['repeat']
        place = TargetChooser(then, pairs.rig, THRESHOLD).place(0)
        yield Case('EuRoC V1_01', place, (now.left, now.right), (then.left, then.right), now.tilt)
    except MissingError as missing:
        run.note(f'Photographs: {missing}')
    taught = teach_corridor(corridor(CorridorDesign(seed=1)))
    for tile in tiles:
        seen = corridor(CorridorDesign(seed=1, tile=tile, needles=1))
        images = render_pair(seen, RIG, TAUGHT @ DISPLACEMENT, np.random.default_rng(1))
        yield Case(f'corridor, tiles of {tile:g} m' if tile else 'corridor', taught.place, images, taught.images)


def match_features(detector: cv2.Feature2D, norm: int, images: Pair) -> None:
    """Detect features in both images and match them."""
    left, right = (detector.detectAndCompute(image, None)[1] for image in images)
    cv2.BFMatcher(norm).knnMatch(left, right, k=2)


def add_case(run: Run, case: Case, repeats: int) -> None:
    """Add the times of a case."""
    localizer = LandmarkLocalizer([case.place])
    locate = partial(localizer.locate, *case.images, case.tilt)
    windows = LandmarkLocalizer([case.place], LandmarkSettings(mode=PAPER))
    orb, sift = 'peer: ORB, 2000 features', 'peer: SIFT, 2000 features'
    fix = locate()
    prior = PlacePrior(case.place.name, state_of(fix.displacement) + OFF if isinstance(fix, LandmarkFix) else None)
    pipeline = FeaturePipeline('SIFT', case.place.rig)
    known = pipeline.teach(case.taught)
    times = side_by_side(
        {
            'first fix, without a prior': locate,
            'followed, with a predicted pose': partial(localizer.locate, *case.images, case.tilt, prior),
            'paper mode: windows': partial(windows.locate, *case.images, case.tilt),
            orb: partial(match_features, cv2.ORB.create(nfeatures=2000), cv2.NORM_HAMMING, case.images),
            sift: partial(match_features, cv2.SIFT.create(nfeatures=2000), cv2.NORM_L2, case.images),
            'peer: SIFT of one image, matched, PnP': lambda: pipeline.motion(known, pipeline.features(case.images[0])),
        },
        repeats,
    )
    table = run.table(case.name, 'what | ms: median / 95 % | in units of ORB')
    for name, milliseconds in times.items():
        units = ratio(milliseconds, times[orb], better='' if name == sift else 'lower')
        table.add(name, time(milliseconds, '.1f'), '1' if name == orb else units)
    scenes = [detect_scene(image, case.place.processing, case.place.kinds) for image in case.images]
    seen = ' and '.join(str(len(scene.segments)) for scene in scenes)
    taught = sum(len(target.primitives) for target in case.place.targets)
    answers = locate(), windows.locate(*case.images, case.tilt)
    found, paper_found = (
        'found' if isinstance(each, LandmarkFix) else f'not found ({each.reason})' for each in answers
    )
    run.note(f'{case.name}: {seen} segments, {taught} primitives taught, {found}; paper mode: {paper_found}.')


def main(run: Run, repeats: int, tiles: tuple[float, ...]) -> None:
    """Look for all places."""
    use_one_core()
    for case in cases(run, tiles):
        add_case(run, case, repeats)


if __name__ == '__main__':
    run_benchmark(
        main, repeats=Option(30, 4, 'runs of each scene'), tiles=Option(TILES, (0.0,), 'of the corridors [m]')
    )
