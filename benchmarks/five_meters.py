"""Five identical meters in a row, four taught as one target (the paper's section 5), ORB and SIFT beside it.

Rendered repeat views; which of them can be decided follows from the truth alone (`_five_views`).
"""

import math
from collections.abc import Iterator
from dataclasses import dataclass, field
from pathlib import Path
from tempfile import TemporaryDirectory

import numpy as np
from _figures import count, error, outcomes
from _five_views import (
    DECIDABLE,
    FOCAL,
    OUT_OF_VIEW,
    T_MAP_LESSON,
    UNDECIDABLE,
    Lesson,
    MeterView,
    lessons,
    meter_points,
    views,
)
from _harness import Option, Run, progress, run_benchmark, use_one_core
from _stereo_peers import FeaturePipeline, TaughtFeatures
from _stereo_scenes import CAMERAS, RIG, Pair, left_pixels
from numpy.typing import NDArray

from scene_simulator.corridor.instruments import Meter
from shirube_core.geometry import SE2
from stereo_landmark.core.landmark_localizer import LandmarkFix, LandmarkLocalizer
from stereo_landmark.core.primitives.primitive import ImageProcessing, Primitive, PrimitiveKind, primitive_size
from stereo_landmark.core.procedure.stereo_view import StereoView, detect_scene
from stereo_landmark.core.procedure.taught_place import TaughtPlace
from stereo_landmark.core.settings import PAPER, LandmarkSettings
from stereo_landmark.core.stereo import StereoImages
from stereo_landmark.core.stereo_landmark_error import StereoLandmarkError
from stereo_landmark.core.teaching.primitive_selection import TargetSelection
from stereo_landmark.core.teaching.teacher import Teacher
from stereo_landmark.files.place_file import save_place

VIEWS_PER_LESSON = 5
CHOSEN_WITHIN = 5.0  # the engineer takes the primitives that are so near to those of a meter [px]
AROUND_TARGET = 45.0  # of a meter's middle, what features of the target are [px]
CONDITIONS = ((False, False), (False, True), (True, False), (True, True))
OURS, PAPER_MODE = 'shirube', 'shirube, paper mode'
KINDS = {
    'round': (PrimitiveKind.ELLIPSE,),
    'square': (PrimitiveKind.QUADRILATERAL,),
    'lined': (PrimitiveKind.ELLIPSE, PrimitiveKind.PARALLEL_LINES),
}
"""Primitives that are taught of a meter, the surest first, by its case: the paper's figure 4 and section 5."""
SIZES = {PrimitiveKind.ELLIPSE: 1.0, PrimitiveKind.QUADRILATERAL: math.sqrt(2.0), PrimitiveKind.PARALLEL_LINES: 0.5}
"""Sizes of these primitives, see `primitive_size`, in radii."""
SIZE_TOLERANCE = 0.25  # largest relative difference from that size
LINES_BELOW = 1.55  # middle of the lines of a lined meter below its own, in radii
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
        self.place = taught_place(lesson)
        self._localizers = {
            OURS: LandmarkLocalizer([self.place]),
            PAPER_MODE: LandmarkLocalizer([self.place], LandmarkSettings(mode=PAPER)),
        }
        self._pipelines = pipelines
        self._taught = [pipeline.teach(lesson.pair) for pipeline in pipelines]
        self._middles = meter_centres(lesson)

    @property
    def feature_bytes(self) -> int:
        """Size of the features of the last pipeline, pixels and descriptors [B]."""
        taught = self._taught[-1]
        return int(taught.pixels.nbytes + taught.descriptors.nbytes)

    def answers(self, view: MeterView) -> Iterator[tuple[str, SE2 | str | None]]:
        """Yield each method's name and answer."""
        for name, localizer in self._localizers.items():
            fix = localizer.locate(*view.pair)
            yield name, fix.displacement.T_place_base if isinstance(fix, LandmarkFix) else fix.reason
        for pipeline, taught in zip(self._pipelines, self._taught, strict=True):
            now = pipeline.features(view.pair[0])
            yield f'{pipeline.name}, whole image', pipeline.locate(taught, now)
            yield f'{pipeline.name}, target', pipeline.locate(self._select_target(taught), now)

    def _select_target(self, taught: TaughtFeatures) -> TaughtFeatures:
        ways = np.linalg.norm(taught.pixels[:, None] - self._middles, axis=2)
        return taught.select((ways <= AROUND_TARGET).any(axis=1))


def meter_centres(lesson: Lesson) -> NDArray[np.float64]:
    """Return where the left camera sees the meters of the target, shape (4, 2) [px]."""
    return left_pixels(meter_points(lesson.scene)[list(lesson.chosen)], T_MAP_LESSON)


def taught_place(lesson: Lesson) -> TaughtPlace:
    """Return the place with the four meters as its target.

    Raises:
        StereoLandmarkError: a meter cannot be taught.
    """
    processing = ImageProcessing()
    left, right = (detect_scene(image, processing) for image in lesson.pair)
    teacher = Teacher(StereoView(left, right, CAMERAS), processing)
    chosen = {
        f'meter {number} {kind.value}': _choose(teacher, kind, middle, lesson)
        for number, middle in zip(lesson.chosen, meter_centres(lesson), strict=True)
        for kind in KINDS[lesson.design.case]
    }
    return teacher.teach('corridor', [TargetSelection('meters', chosen)])


def _choose(teacher: Teacher, kind: PrimitiveKind, middle: NDArray[np.float64], lesson: Lesson) -> Primitive:
    """Return the primitive of a meter that is nearest to its size and can be measured: its rim or its face."""
    meters = {each.name: each for each in lesson.scene.objects if isinstance(each, Meter)}
    radius = meters['meter_0'].radius * FOCAL / (-T_MAP_LESSON.x - RIG.mount.xyz[0])
    shift = LINES_BELOW * radius if kind is PrimitiveKind.PARALLEL_LINES else 0.0
    sizes = {
        each: abs(primitive_size(each) / (SIZES[kind] * radius) - 1.0)
        for each in teacher.view.left.kinds[kind].primitives
        if np.hypot(*(each.centre - middle - [0.0, shift])) <= CHOSEN_WITHIN
    }
    for primitive in sorted(sizes, key=lambda each: sizes[each]):
        if sizes[primitive] <= SIZE_TOLERANCE and teacher.can_measure(primitive):
            return primitive
    raise StereoLandmarkError(f'{kind.value} of a meter is not detected')


def size_on_disk(place: TaughtPlace, pair: Pair) -> tuple[int, int]:
    """Return the sizes of the place's file and of its images [B]."""
    with TemporaryDirectory() as folder:
        file = save_place(Path(folder), place, StereoImages(*pair))
        images = sum(each.stat().st_size for each in Path(folder).glob('*.png'))
        return file.stat().st_size, images


def taught_views(
    run: Run, wanted: int, case: str, *, even: bool, bare: bool, posters: bool
) -> Iterator[tuple[Lesson, Methods, MeterView]]:
    """Yield so many views of one condition, with the methods that were taught."""
    pipelines = [FeaturePipeline(name, CAMERAS) for name in ('ORB', 'SIFT')]
    for lesson in lessons(even=even, bare=bare, seed=run.seed, case=case, posters=posters):
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


def main(run: Run, corridors: int, conditions: int, case: str, posters: bool) -> None:
    """Ask all methods about the views."""
    use_one_core()
    total, statuses = Score(), (DECIDABLE, UNDECIDABLE, OUT_OF_VIEW)
    kinds = ('found', 'ambiguous', 'none', 'mistaken')
    table = run.table('Views', 'gaps, surroundings: found / ambiguous / no pose / mistaken', *statuses)
    for even, bare in CONDITIONS[-conditions:]:
        score, wanted = Score(), VIEWS_PER_LESSON * corridors
        shown = taught_views(run, wanted, case, even=even, bare=bare, posters=posters)
        for lesson, methods, view in progress(shown, total=wanted):
            for method, found in methods.answers(view):
                score.add(method, lesson, view, found)
                total.add(method, lesson, view, found)
        name = f'{"even" if even else "uneven"}, {"bare wall" if bare else "panels, doors, signs"}'
        for method in (OURS, PAPER_MODE):
            verdicts = (score.answers.get((method, status), []) for status in statuses)
            table.add(f'{name}: {method}', *(outcomes(each, kinds) for each in verdicts))
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
    table = run.table('Size of the last place', 'what | B')
    file, images = size_on_disk(methods.place, lesson.pair)
    table.add('taught data (3.3 a to e)', count(file, unit='B'))
    table.add('images, for patches and editing', count(images, unit='B'))
    table.add('SIFT features of the left image', count(methods.feature_bytes, unit='B'))


if __name__ == '__main__':
    run_benchmark(
        main,
        case=Option('round', 'square', 'of the meters: round, square (section 5) or lined (figure 4)'),
        corridors=Option(50, 1, 'of each condition, five views each'),
        conditions=Option(len(CONDITIONS), 1, 'of them, from the last'),
        posters=Option(False, False, 'repeat posters and plates beside each meter'),
    )
