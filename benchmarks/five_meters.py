"""Five identical meters in a row, four taught as one target: `./shirube bench five_meters`.

Prints the markdown of the section "Five meters" of stereo_landmark.md: the paper's experiment (section 5) with rendered
repeat views, and pipelines of ORB and SIFT on the same views.
"""

from __future__ import annotations

import argparse
import sys
from collections.abc import Iterator

import numpy as np
from _five_score import OURS, Score, print_scores
from _five_views import RIG, T_MAP_LESSON, Lesson, MeterView, lessons, views
from _product_rig import product_rig
from _stereo_peers import FeaturePipeline, TaughtFeatures
from _timed_answers import use_one_core
from numpy.typing import NDArray
from tqdm import tqdm

from shirube_core.geometry import SE2
from stereo_landmark.core.landmark_fix import LandmarkFix
from stereo_landmark.core.landmark_localizer import LandmarkLocalizer
from stereo_landmark.core.primitives.primitive import ImageProcessing, PrimitiveKind, primitive_size
from stereo_landmark.core.procedure.stereo_view import StereoView, detect_scene
from stereo_landmark.core.procedure.taught_place import TaughtPlace
from stereo_landmark.core.stereo_landmark_error import StereoLandmarkError
from stereo_landmark.core.teaching.primitive_selection import TargetSelection
from stereo_landmark.core.teaching.teacher import Teacher

VIEWS_PER_LESSON = 5
CHOSEN_WITHIN = 5.0
"""The engineer takes the ellipse that is so near to a meter's middle [px]."""
AROUND_TARGET = 45.0
"""Of a meter's middle, what features of the target are [px]."""
CONDITIONS = ((False, False), (False, True), (True, False), (True, True))
CAMERAS = product_rig(RIG)


class Methods:
    """All methods, taught with one lesson.

    Raises:
        StereoLandmarkError: a meter cannot be taught.
    """

    def __init__(self, lesson: Lesson, pipelines: list[FeaturePipeline]) -> None:
        self._localizer = LandmarkLocalizer([taught_place(lesson)])
        self._pipelines = pipelines
        self._taught = [pipeline.teach(lesson.pair) for pipeline in pipelines]
        self._middles = meter_centres(lesson)

    def answers(self, view: MeterView) -> Iterator[tuple[str, SE2 | str | None]]:
        """Yield each method's name and answer."""
        fix = self._localizer.locate(*view.pair)
        yield OURS, fix.displacement.T_place_base if isinstance(fix, LandmarkFix) else fix.reason
        for pipeline, taught in zip(self._pipelines, self._taught, strict=True):
            now = pipeline.features(view.pair[0])
            yield f'{pipeline.name}, whole image', pipeline.locate(taught, now)
            yield f'{pipeline.name}, target', pipeline.locate(self._select_target(taught), now)

    def _select_target(self, taught: TaughtFeatures) -> TaughtFeatures:
        ways = np.linalg.norm(taught.pixels[:, None] - self._middles, axis=2)
        return taught.select((ways <= AROUND_TARGET).any(axis=1))


def meter_centres(lesson: Lesson) -> NDArray[np.float64]:
    """Return where the left camera sees the meters of the target, shape (4, 2) [px]."""
    points = lesson.scene.points_map()
    places = np.array([points[f'meter_{i}'] for i in lesson.chosen])
    camera = RIG.camera_poses(T_MAP_LESSON)[0]
    return RIG.left.intrinsics.pixels_from_points(camera.camera_points(places))


def taught_place(lesson: Lesson) -> TaughtPlace:
    """Return the place with the four meters as its target.

    Raises:
        StereoLandmarkError: a meter cannot be taught.
    """
    processing = ImageProcessing()
    left, right = (detect_scene(image, processing) for image in lesson.pair)
    chosen = {}
    for number, middle in zip(lesson.chosen, meter_centres(lesson), strict=True):
        near = [
            each
            for each in left.kinds[PrimitiveKind.ELLIPSE].primitives
            if np.hypot(*(each.centre - middle)) <= CHOSEN_WITHIN
        ]
        if not near:
            raise StereoLandmarkError('a meter is not detected')
        chosen[f'meter {number}'] = max(near, key=primitive_size)
    teacher = Teacher(StereoView(left, right, CAMERAS), processing)
    return teacher.teach('corridor', [TargetSelection('meters', chosen)])


def run(*, even: bool, bare: bool, wanted: int, seed: int, bar: tqdm[None]) -> Score:
    """Return the answers to so many views of one condition."""
    score = Score()
    pipelines = [FeaturePipeline(name, CAMERAS) for name in ('ORB', 'SIFT')]
    done = 0
    for lesson in lessons(even=even, bare=bare, seed=seed):
        try:
            methods = Methods(lesson, pipelines)
        except StereoLandmarkError as fault:
            score.untaught.append(f'corridor {lesson.design.seed}: {fault}')
            continue
        for view in views(lesson, min(VIEWS_PER_LESSON, wanted - done)):
            for method, found in methods.answers(view):
                score.add(method, lesson, view, found)
            done += 1
            bar.update()
        if done >= wanted:
            return score
    raise AssertionError


def main() -> int:
    """Print the tables."""
    parser = argparse.ArgumentParser(description='Five identical meters, four of them taught as one target.')
    parser.add_argument('--views', type=int, default=1000, help='a quarter of them of each condition')
    parser.add_argument('--seed', type=int, default=100, help='of the first corridor')
    arguments = parser.parse_args()
    use_one_core()
    scores = {}
    wanted = max(1, arguments.views // len(CONDITIONS))
    with tqdm(total=wanted * len(CONDITIONS), leave=False) as bar:
        for even, bare in CONDITIONS:
            name = f'{"even" if even else "uneven"}, {"bare wall" if bare else "panels, doors, signs"}'
            scores[name] = run(even=even, bare=bare, wanted=wanted, seed=arguments.seed, bar=bar)
    print_scores(scores)
    return 0


if __name__ == '__main__':
    sys.exit(main())
