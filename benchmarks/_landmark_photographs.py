"""Targets of quadrilaterals in a real pair, chosen at random, for the speed."""

from __future__ import annotations

import numpy as np
from _real_pairs import Moment

from stereo_landmark.core.primitives.primitive import (
    ImageProcessing,
    Primitive,
    PrimitiveKind,
    primitive_size,
)
from stereo_landmark.core.procedure.stereo_view import StereoView, detect_scene
from stereo_landmark.core.procedure.taught_place import TaughtPlace
from stereo_landmark.core.settings import EdgeSettings
from stereo_landmark.core.stereo import StereoRig
from stereo_landmark.core.stereo_landmark_error import StereoLandmarkError
from stereo_landmark.core.teaching.primitive_selection import TargetSelection
from stereo_landmark.core.teaching.teacher import Teacher

THRESHOLD = 3.31
"""With which each photograph has nearly 1000 segments [grey levels / px]."""
SIZE_MIN, APART = 14.0, 30.0
"""Of the quadrilaterals that are taught [px]."""


def teach_photographs(rig: StereoRig, pair: Moment, count: int, seed: int) -> TaughtPlace:
    """Teach quadrilaterals, chosen at random, that lie apart and can be measured, as one target.

    Args:
        rig: the cameras.
        pair: the one to teach.
        count: greatest number of quadrilaterals.
        seed: random seed of the choice.
    """
    processing = ImageProcessing(edges=EdgeSettings(threshold=THRESHOLD))
    left, right = (detect_scene(image, processing) for image in (pair.left, pair.right))
    view = StereoView(left, right, rig, pair.tilt)
    teacher = Teacher(view, processing)
    parts: dict[str, Primitive] = {}
    found = view.left.kinds[PrimitiveKind.QUADRILATERAL].primitives
    for number in np.random.default_rng(seed).permutation(len(found)).tolist():
        apart = [np.hypot(*(found[number].centre - other.centre)) for other in parts.values()]
        if (
            len(parts) < count
            and primitive_size(found[number]) >= SIZE_MIN
            and min(apart, default=np.inf) >= APART
        ):
            try:
                teacher.measure(found[number])
            except StereoLandmarkError:
                continue
            parts[f'part {number}'] = found[number]
    return teacher.teach('room', [TargetSelection('target', parts)])
