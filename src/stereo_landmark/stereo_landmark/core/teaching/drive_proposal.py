"""Proposes the targets of a place from a drive around it: those that are found again from its pairs (paper 4b and d).

The pair in the middle of the drive is taught. Whatever the tools can measure in it is a candidate; how often each is
found again in the other pairs decides.
"""

from collections import Counter
from collections.abc import Callable, Sequence
from dataclasses import dataclass

import numpy as np

from stereo_landmark.core.arrays import Floats
from stereo_landmark.core.landmark_localizer import LandmarkFix, LandmarkLocalizer, NoLandmarkFix
from stereo_landmark.core.primitives.primitive import ImageProcessing, Primitive, PrimitiveKind, primitive_size
from stereo_landmark.core.procedure.stereo_view import StereoView, detect_scene
from stereo_landmark.core.procedure.target_search import TargetDetection
from stereo_landmark.core.procedure.taught_place import TaughtPlace
from stereo_landmark.core.settings import LandmarkSettings
from stereo_landmark.core.stereo import StereoImages, StereoRig
from stereo_landmark.core.stereo_landmark_error import StereoLandmarkError
from stereo_landmark.core.teaching.primitive_selection import TargetSelection
from stereo_landmark.core.teaching.teacher import Teacher

KINDS = (PrimitiveKind.QUADRILATERAL, PrimitiveKind.ELLIPSE, PrimitiveKind.CORNER)
CANDIDATES_MAX, CHOSEN_MAX, CHOSEN_MIN = 24, 10, 3
SIZE_MIN, DISTANCE_MIN = 12.0, 25.0
"""Smallest size of a candidate, and smallest distance between two [px]."""
RECALL_MIN = 0.7
"""Smallest fraction of the localized pairs in which a proposed primitive is found again."""
TARGET = 'view'


@dataclass(frozen=True)
class DriveProposal:
    """A proposed place, and what it achieves on the drive.

    Attributes:
        taught: number of the taught pair.
        place: the place with the proposed target.
        recall: fraction of the localized pairs in which each proposed primitive is found.
        results: result of each pair of the drive.
    """

    taught: int
    place: TaughtPlace
    recall: dict[str, float]
    results: tuple[LandmarkFix | NoLandmarkFix, ...]

    @property
    def poses(self) -> Floats:
        """x, y [m] and yaw [rad] of the localized pairs in the place's frame, shape (n, 3)."""
        poses = [each.displacement.T_place_base for each in self.results if isinstance(each, LandmarkFix)]
        return np.array([(pose.x, pose.y, pose.yaw) for pose in poses]).reshape(-1, 3)


def propose_place(
    name: str, count: int, images: Callable[[int], StereoImages], rig: StereoRig, settings: LandmarkSettings
) -> DriveProposal:
    """Propose a place from the pairs of a drive.

    Raises:
        StereoLandmarkError: too little in view can be measured, or is found again.
    """
    taught = count // 2
    pair, processing = images(taught), ImageProcessing()
    left, right = (detect_scene(image, processing) for image in (pair.left, pair.right))
    teacher = Teacher(StereoView(left, right, rig, pair.tilt), processing)
    # 1. Candidates: what can be measured, the largest first.
    shapes = list_candidates(teacher)
    if len(shapes) < CHOSEN_MIN:
        raise StereoLandmarkError(
            f'only {len(shapes)} shapes in the middle of the drive can be measured in both images, {CHOSEN_MIN} are '
            'needed; drive where signs, doors or instruments are in view'
        )
    # 2. How often each is found again.
    results = localize_pairs(teacher.teach(name, [TargetSelection(TARGET, shapes)]), count, images, settings)
    found = Counter(part for result in results if isinstance(result, LandmarkFix) for part in _found(result))
    located = sum(isinstance(result, LandmarkFix) for result in results)
    # 3. The most reliable ones make the target, in this order.
    order = sorted(shapes, key=lambda part: -found[part])
    chosen = {part: shapes[part] for part in order[:CHOSEN_MAX] if found[part] >= RECALL_MIN * max(located, 1)}
    if len(chosen) < CHOSEN_MIN:
        raise StereoLandmarkError(
            f'only {len(chosen)} of {len(shapes)} shapes are found again in {100.0 * RECALL_MIN:.0f} % of the '
            f'{located} localized pairs ({count} in all); drive slower and nearer, or teach on the page'
        )
    # 4. What the place achieves.
    place = teacher.teach(name, [TargetSelection(TARGET, chosen)])
    recall = {part: found[part] / located for part in chosen}
    return DriveProposal(taught, place, recall, tuple(localize_pairs(place, count, images, settings)))


def list_candidates(teacher: Teacher) -> dict[str, Primitive]:
    """Return measurable primitives by name, apart from each other."""
    chosen: dict[str, Primitive] = {}
    detected = [each for kind in KINDS for each in teacher.view.left.kinds[kind].primitives]
    for shape in sorted(detected, key=lambda each: -primitive_size(each)):
        if len(chosen) == CANDIDATES_MAX or primitive_size(shape) < SIZE_MIN:
            break
        is_apart = all(np.hypot(*(shape.centre - other.centre)) >= DISTANCE_MIN for other in chosen.values())
        if is_apart and teacher.can_measure(shape):
            chosen[f'{type(shape).__name__.lower()} {len(chosen) + 1}'] = shape
    return chosen


def localize_pairs(
    place: TaughtPlace, count: int, images: Callable[[int], StereoImages], settings: LandmarkSettings
) -> list[LandmarkFix | NoLandmarkFix]:
    """Return the result of each pair at one place; arguments as for `propose_place`."""
    localizer = LandmarkLocalizer([place], settings)
    pairs = (images(number) for number in range(count))
    return [localizer.locate(pair.left, pair.right, pair.tilt) for pair in pairs]


def _found(result: LandmarkFix) -> Sequence[str]:
    """Return the names of the primitives of the proposed target that were found."""
    found = [name for each in result.detections if isinstance(each, TargetDetection) for name in each.found]
    return [name.removeprefix(f'{TARGET}/') for name in found]
