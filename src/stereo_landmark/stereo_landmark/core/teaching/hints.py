"""What a selection is worth: its points with the expected pose, and hints about its weaknesses (paper 4c and d)."""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from enum import Enum

import numpy as np

from stereo_landmark.core.place.place_locator import NoPlaceFix, PlaceFix, PlaceLocator
from stereo_landmark.core.primitives.primitive import Primitive, bounding_box, difference, primitive_kind
from stereo_landmark.core.procedure.stereo_view import stereo_points
from stereo_landmark.core.settings import PlaceSettings
from stereo_landmark.core.stereo import SpatialPoints, StereoPoints
from stereo_landmark.core.stereo_landmark_error import StereoLandmarkError
from stereo_landmark.core.teaching.geometry_hints import check_geometry, find_skewed_shapes
from stereo_landmark.core.teaching.primitive_selection import TargetSelection
from stereo_landmark.core.teaching.teacher import Teacher

POINT_SIGMA_MAX = 0.1
"""Recommended maximum standard deviation of a point [m]."""
PRIMITIVES_RECOMMENDED = 3
"""Recommended number of primitives, so that one may be hidden."""
SIMILAR_MAX = 8
"""Recommended maximum number of shapes similar to the first primitive; more make the search slow."""
BORDER_FRACTION = 0.06
"""Recommended minimum distance from the image border, as a fraction of the image width."""
NOT_DETECTED = 'it is not detected with this image processing; remove it, or undo the change'


class Severity(Enum):
    """Severity of a hint."""

    STOP = 'stop'
    WEAK = 'weak'
    NOTE = 'note'


@dataclass(frozen=True)
class Hint:
    """A problem of a target and its remedy.

    Attributes:
        severity: severity; STOP if the place cannot be saved.
        target: name of the target.
        about: name of the primitive or point, empty for the whole target.
        text: message, one sentence.
    """

    severity: Severity
    target: str
    about: str
    text: str


@dataclass(frozen=True, eq=False)
class TargetReport:
    """Results for a selected target.

    Attributes:
        measured: each primitive refined in both images, or the reason why it cannot be measured.
        points: corresponding points of the measured primitives, named ``primitive/point``.
        coordinates: triangulated points in the place's frame.
        fix: expected pose from its used points, with covariance.
        hints: hints about the selection, the most severe first.
    """

    measured: dict[str, tuple[Primitive, Primitive] | str]
    points: StereoPoints
    coordinates: SpatialPoints
    fix: PlaceFix | NoPlaceFix
    hints: list[Hint]


def report_target(
    selection: TargetSelection,
    shapes: Mapping[str, Primitive | None],
    teacher: Teacher,
    settings: PlaceSettings,
) -> TargetReport:
    """Measure a selected target and check it.

    Args:
        selection: selected target.
        shapes: its primitives as the teacher's view detects them; None for those that it does not.
        teacher: teacher of the stereo pair.
        settings: settings of the displacement estimate.
    """
    measured = {name: _measure(name, shape, teacher) for name, shape in shapes.items()}
    pairs = {name: pair for name, pair in measured.items() if not isinstance(pair, str)}
    points = stereo_points((name, *pair) for name, pair in pairs.items())
    coordinates = teacher.coordinates(points)
    used = points.subset(np.array([selection.uses(name) for name in points.names], dtype=np.bool_))
    view = teacher.view
    fix = PlaceLocator(view.rig, settings).locate(used, coordinates, view.tilt)
    lefts = {name: left for name, (left, _) in pairs.items()}
    found = [
        *((Severity.STOP, name, fault) for name, fault in measured.items() if isinstance(fault, str)),
        *_check_fix(selection, coordinates, fix),
        *_uncertain_points(selection, coordinates),
        *((Severity.WEAK, name, text) for name, text in find_skewed_shapes(lefts, coordinates)),
        *_near_border(measured, teacher),
        *_similar_shapes(selection, teacher),
    ]
    hints = [Hint(severity, selection.name, about, text) for severity, about, text in found]
    hints.sort(key=lambda hint: list(Severity).index(hint.severity))
    return TargetReport(measured, points, coordinates, fix, hints)


_Remark = tuple[Severity, str, str]
"""Severity, name of the primitive or point, text."""


def _measure(name: str, shape: Primitive | None, teacher: Teacher) -> tuple[Primitive, Primitive] | str:
    if shape is None:
        return NOT_DETECTED
    try:
        pair = teacher.measure(shape)
        teacher.coordinates(stereo_points([(name, *pair)]))
    except StereoLandmarkError as fault:
        return str(fault)
    return pair


def _check_fix(
    selection: TargetSelection, coordinates: SpatialPoints, fix: PlaceFix | NoPlaceFix
) -> Iterator[_Remark]:
    count = len(selection.primitives)
    if not count:
        text = 'no primitive is selected; draw a region and click on shapes, or remove the target'
        yield Severity.STOP, '', text
        return
    if isinstance(fix, NoPlaceFix):
        text = f'{fix.reason.value} ({fix.detail}); select more points, farther apart or nearer'
        yield Severity.STOP, '', text
        return
    if count < PRIMITIVES_RECOMMENDED:
        text = (
            f'too few primitives: {count}, select {PRIMITIVES_RECOMMENDED} or more, since one may be hidden'
        )
        yield Severity.WEAK, '', text
    for text in check_geometry(coordinates.select(fix.names).positions, fix):
        yield Severity.WEAK, '', text


def _uncertain_points(selection: TargetSelection, points: SpatialPoints) -> Iterator[_Remark]:
    for name, covariance in zip(points.names, points.covariances, strict=True):
        sigma = math.sqrt(float(np.linalg.eigvalsh(covariance)[-1]))
        if sigma > POINT_SIGMA_MAX and selection.uses(name):
            text = f'{name} has a standard deviation of {100.0 * sigma:.0f} cm; exclude the point'
            yield Severity.WEAK, name, text


def _near_border(
    measured: Mapping[str, tuple[Primitive, Primitive] | str], teacher: Teacher
) -> Iterator[_Remark]:
    name, pair = next(iter(measured.items()), ('', ''))
    if len(measured) < 2 or isinstance(pair, str):
        return
    camera = teacher.view.rig.left
    boxes = [bounding_box(shape) for shape in pair]
    distance = min(float(min(low.min(), *([camera.width, camera.height] - high))) for low, high in boxes)
    if distance < BORDER_FRACTION * camera.width:
        text = (
            f'{name} is {max(distance, 0.0):.0f} px from the border and soon out of view; move it to the end'
        )
        yield Severity.NOTE, name, text


def _similar_shapes(selection: TargetSelection, teacher: Teacher) -> Iterator[_Remark]:
    for name, first in list(selection.primitives.items())[:1]:
        detected = teacher.view.left.kinds[primitive_kind(first)].primitives
        similar = sum(difference(each, first, teacher.processing.tolerances) <= 1.0 for each in detected)
        if similar > SIMILAR_MAX:
            text = f'{similar} shapes in the image are similar to {name}; put a rarer primitive first'
            yield Severity.NOTE, name, text
