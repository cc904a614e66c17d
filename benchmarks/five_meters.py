"""Five identical meters in a row, four taught as one target (the paper's section 5), ORB and SIFT beside it.

Rendered repeat views; which of them can be decided follows from the truth alone (`_five_views`).
"""

from __future__ import annotations

import math
from collections.abc import Iterator
from dataclasses import dataclass, field

import numpy as np
from _figures import error, outcomes
from _five_views import DECIDABLE, OUT_OF_VIEW, T_MAP_LESSON, UNDECIDABLE, Lesson, MeterView, lessons, views
from _harness import Option, Run, progress, run_benchmark, use_one_core
from _stereo_peers import FeaturePipeline, TaughtFeatures
from _stereo_scenes import CAMERAS, left_pixels
from numpy.typing import NDArray

from shirube_core.geometry import SE2
from stereo_landmark.core.landmark_localizer import LandmarkFix, LandmarkLocalizer
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
OURS = 'shirube'
AMBIGUOUS = 'ambiguous: several poses match'


@dataclass
class Score:
    """Answers of the methods to views: by method and status of the view 'found', 'mistaken', 'ambiguous' or 'none'.

    Attributes:
        answers: the verdicts.
        errors: position [m] and heading [rad] of what each method found.
    """

    answers: dict[tuple[str, str], list[str]] = field(default_factory=dict)
    errors: dict[str, list[tuple[float, float]]] = field(default_factory=dict)

    def add(self, method: str, lesson: Lesson, view: MeterView, found: SE2 | str | None) -> None:
        """Add an answer: a pose, or why there is none; a pose half a spacing off is mistaken."""
        verdict = 'ambiguous' if found == AMBIGUOUS else 'none'
        if isinstance(found, SE2):
            distance, turn = found.distance_to(view.T_lesson_base), abs(found.yaw_to(view.T_lesson_base))
            verdict = 'mistaken' if distance > 0.5 * lesson.spacing else 'found'
            if verdict == 'found':
                self.errors.setdefault(method, []).append((distance, turn))
        self.answers.setdefault((method, view.status), []).append(verdict)


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
    return left_pixels(np.array([points[f'meter_{i}'] for i in lesson.chosen]), T_MAP_LESSON)


def taught_place(lesson: Lesson) -> TaughtPlace:
    """Return the place with the four meters as its target.

    Raises:
        StereoLandmarkError: a meter cannot be taught.
    """
    processing = ImageProcessing()
    left, right = (detect_scene(image, processing) for image in lesson.pair)
    chosen = {}
    for number, middle in zip(lesson.chosen, meter_centres(lesson), strict=True):
        ellipses = left.kinds[PrimitiveKind.ELLIPSE].primitives
        near = [each for each in ellipses if np.hypot(*(each.centre - middle)) <= CHOSEN_WITHIN]
        if not near:
            raise StereoLandmarkError('a meter is not detected')
        chosen[f'meter {number}'] = max(near, key=primitive_size)
    teacher = Teacher(StereoView(left, right, CAMERAS), processing)
    return teacher.teach('corridor', [TargetSelection('meters', chosen)])


def taught_views(
    run: Run, wanted: int, *, even: bool, bare: bool
) -> Iterator[tuple[Lesson, Methods, MeterView]]:
    """Yield so many views of one condition, with the methods that were taught."""
    pipelines = [FeaturePipeline(name, CAMERAS) for name in ('ORB', 'SIFT')]
    for lesson in lessons(even=even, bare=bare, seed=run.seed):
        try:
            methods = Methods(lesson, pipelines)
        except StereoLandmarkError as fault:
            run.note(f'Not taught: corridor {lesson.design.seed}: {fault}')
            continue
        for view in views(lesson, min(VIEWS_PER_LESSON, wanted)):
            yield lesson, methods, view
            wanted -= 1
        if wanted <= 0:
            return


def main(run: Run, corridors: int, conditions: int) -> None:
    """Ask all methods about the views."""
    use_one_core()
    total, statuses = Score(), (DECIDABLE, UNDECIDABLE, OUT_OF_VIEW)
    kinds = ('found', 'ambiguous', 'none', 'mistaken')
    table = run.table('Views', 'gaps, surroundings: found / ambiguous / no pose / mistaken', *statuses)
    for even, bare in CONDITIONS[-conditions:]:
        score, wanted = Score(), VIEWS_PER_LESSON * corridors
        for lesson, methods, view in progress(taught_views(run, wanted, even=even, bare=bare), total=wanted):
            for method, found in methods.answers(view):
                score.add(method, lesson, view, found)
                total.add(method, lesson, view, found)
        name = f'{"even" if even else "uneven"}, {"bare wall" if bare else "panels, doors, signs"}'
        table.add(name, *(outcomes(score.answers.get((OURS, status), []), kinds) for status in statuses))
    table.add('all', *(outcomes(total.answers.get((OURS, status), []), kinds) for status in statuses))
    heads = 'method | decidable: found / no pose / mistaken | others | position mm: median / 95 %'
    table = run.table('Methods', heads, 'heading °: the same')
    for method in dict.fromkeys(method for method, _ in total.answers):
        errors = np.array(total.errors.get(method, [])).reshape(-1, 2)
        answers = [total.answers.get((method, status), []) for status in statuses]
        cells = [
            outcomes(['none' if v == 'ambiguous' else v for v in verdicts], ('found', 'none', 'mistaken'))
            for verdicts in (answers[0], answers[1] + answers[2])
        ]
        cells.append(error(errors[:, 0], '.1f', 1e3, (50, 95)))
        table.add(method, *cells, error(errors[:, 1], '.3f', math.degrees(1.0), (50, 95)))


if __name__ == '__main__':
    run_benchmark(
        main,
        corridors=Option(50, 1, 'of each condition, five views each'),
        conditions=Option(len(CONDITIONS), 1, 'of them, from the last'),
    )
