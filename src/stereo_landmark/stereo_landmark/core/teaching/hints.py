"""What a selection is worth: its points with the expected pose, and hints about its weaknesses (paper 4c and d)."""

import math
from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from enum import Enum

import numpy as np

from stereo_landmark.core.arrays import Floats
from stereo_landmark.core.place.place_locator import NoPlaceFix, PlaceFix, PlaceLocator
from stereo_landmark.core.primitives.primitive import Primitive, bounding_box, difference, primitive_kind
from stereo_landmark.core.primitives.quadrilateral import Quadrilateral
from stereo_landmark.core.procedure.stereo_view import stereo_points
from stereo_landmark.core.settings import PlaceSettings
from stereo_landmark.core.stereo import SpatialPoints, StereoPoints
from stereo_landmark.core.teaching.primitive_selection import TargetSelection
from stereo_landmark.core.teaching.teacher import NOT_DETECTED, Teacher

POINT_SIGMA_MAX = 0.1
"""Recommended maximum standard deviation of a point [m]."""
PRIMITIVES_RECOMMENDED = 3
"""Recommended number of primitives, so that one may be hidden."""
SIMILAR_MAX = 8
"""Recommended maximum number of shapes similar to the first primitive; more make the search slow."""
BORDER_FRACTION = 0.06
"""Recommended minimum distance from the image border, as a fraction of the image width."""


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
    selection: TargetSelection, shapes: Mapping[str, Primitive | None], teacher: Teacher, settings: PlaceSettings
) -> TargetReport:
    """Measure a selected target and check it.

    Args:
        selection: selected target.
        shapes: its primitives as the teacher's view detects them; None for those that it does not.
        teacher: teacher of the stereo pair.
        settings: settings of the displacement estimate.
    """
    measured = {name: _measure(shape, teacher) for name, shape in shapes.items()}
    pairs = {name: pair for name, pair in measured.items() if not isinstance(pair, str)}
    points = stereo_points((name, *pair) for name, pair in pairs.items())
    coordinates = teacher.coordinates(points)
    used = points.subset(np.array([selection.uses(name) for name in points.names], dtype=np.bool_))
    view = teacher.view
    fix = PlaceLocator(view.rig, settings).locate(used, coordinates, view.tilt)
    lefts = {name: left for name, (left, _) in pairs.items()}
    found = [
        *((Severity.WEAK, name, f'{name}: {fault}') for name, fault in measured.items() if isinstance(fault, str)),
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


def _measure(shape: Primitive | None, teacher: Teacher) -> tuple[Primitive, Primitive] | str:
    if shape is None:
        return NOT_DETECTED
    return teacher.fault(shape) or teacher.measure(shape)


def _check_fix(selection: TargetSelection, coordinates: SpatialPoints, fix: PlaceFix | NoPlaceFix) -> Iterator[_Remark]:
    count = len(selection.primitives)
    if isinstance(fix, NoPlaceFix):
        text = f'{fix.reason.value} ({fix.detail}); select more points, farther apart or nearer'
        if not count:
            text = 'no shape is selected; draw a region and click on shapes, or remove the target'
        yield Severity.STOP, '', text
        return
    if count < PRIMITIVES_RECOMMENDED:
        text = f'too few shapes: {count}, select {PRIMITIVES_RECOMMENDED} or more, since one may be hidden'
        yield Severity.WEAK, '', text
    warnings = check_geometry(coordinates.select(fix.names).positions, fix)
    yield from ((Severity.WEAK, '', text) for text in warnings)


def _uncertain_points(selection: TargetSelection, points: SpatialPoints) -> Iterator[_Remark]:
    for name, covariance in zip(points.names, points.covariances, strict=True):
        sigma = math.sqrt(float(np.linalg.eigvalsh(covariance)[-1]))
        if sigma > POINT_SIGMA_MAX and selection.uses(name):
            text = f'{name} is only known to ± {100.0 * sigma:.0f} cm; exclude the point'
            yield Severity.WEAK, name, text


def _near_border(measured: Mapping[str, tuple[Primitive, Primitive] | str], teacher: Teacher) -> Iterator[_Remark]:
    name, pair = next(iter(measured.items()), ('', ''))
    if len(measured) < 2 or isinstance(pair, str):
        return
    camera = teacher.view.rig.left
    boxes = [bounding_box(shape) for shape in pair]
    gap = min(float(min(low.min(), *([camera.width, camera.height] - high))) for low, high in boxes)
    if gap < BORDER_FRACTION * camera.width:
        text = f'{name} is {max(gap, 0.0):.0f} px from the border and soon out of view; move it to the end'
        yield Severity.NOTE, name, text


def _similar_shapes(selection: TargetSelection, teacher: Teacher) -> Iterator[_Remark]:
    for name, first in list(selection.primitives.items())[:1]:
        detected = teacher.view.left.kinds[primitive_kind(first)].primitives
        similar = sum(difference(each, first, teacher.processing.tolerances) <= 1.0 for each in detected)
        if similar > SIMILAR_MAX:
            text = f'{similar} shapes in the image are similar to {name}; put a rarer shape first'
            yield Severity.NOTE, name, text


POINTS_RECOMMENDED = 4
"""Recommended number of points: with fewer, no point may be hidden."""
POSITION_SIGMA_MAX = 0.02
"""Recommended maximum standard deviation of the position [m]."""
YAW_SIGMA_MAX = math.radians(0.5)
"""Recommended maximum standard deviation of the yaw [rad]."""
DISTINCT_DISTANCE = 0.02
"""Minimum distance of distinct points; nearer ones, such as two rims of one meter, are hidden together [m]."""
EXTENT_MIN = 0.3
"""Recommended minimum horizontal extent of the points, for an observable yaw [m]."""


def check_geometry(positions: Floats, fix: PlaceFix | None) -> list[str]:
    """Return warnings with remedies, one line each, none for a good geometry.

    Args:
        positions: points used for the pose in the place's frame, shape (n, 3) [m].
        fix: pose at the taught place from these points, None if there is none.
    """
    warnings = [] if fix is None else _check_uncertainty(positions, fix)
    count = len(positions)
    if count < POINTS_RECOMMENDED:
        text = f'too few points: {count}, select {POINTS_RECOMMENDED} or more, since some may be hidden'
        return [*warnings, text]
    distinct = count_distinct_points(positions)
    if distinct < POINTS_RECOMMENDED:
        warnings.append(
            f'too close together: {count} points at {distinct} distinct positions; '
            f'select points at {POINTS_RECOMMENDED} or more'
        )
    extent = horizontal_extent(positions)
    if extent < EXTENT_MIN:
        warnings.append(f'too narrow: the horizontal extent is {extent:.2f} m; spread them over {EXTENT_MIN} m or more')
    return warnings


def count_distinct_points(positions: Floats) -> int:
    """Return the number of distinct positions of points, shape (n, 3) [m]."""
    distinct = np.empty((0, 3))
    for position in positions:
        if not (np.linalg.norm(distinct - position, axis=1) < DISTINCT_DISTANCE).any():
            distinct = np.vstack([distinct, position])
    return len(distinct)


def horizontal_extent(positions: Floats) -> float:
    """Return the horizontal extent of points, shape (n, 3) with n > 0 [m]."""
    middle = positions[:, :2] - positions[:, :2].mean(axis=0)
    return float(np.ptp(middle @ np.linalg.svd(middle)[2][0]))


def _check_uncertainty(positions: Floats, fix: PlaceFix) -> list[str]:
    warnings = []
    if fix.position_sigma > POSITION_SIGMA_MAX:
        far = float(np.linalg.norm(positions, axis=1).mean())
        warnings.append(
            f'too shallow: at {far:.1f} m the position is only known to ± {100 * fix.position_sigma:.1f} cm; '
            'select nearer points, more points, or points at another depth'
        )
    if (yaw := fix.yaw_sigma) > YAW_SIGMA_MAX:
        warnings.append(f'the heading is only known to ± {math.degrees(yaw):.1f}°; select points farther apart')
    return warnings


SKEW_MAX = 0.05
"""Opposite sides of a rectangle differ in 3D by a smaller fraction than this,"""
SKEW_SIGMAS = 5.0
"""or by fewer standard deviations."""


def find_skewed_shapes(shapes: Mapping[str, Primitive], coordinates: SpatialPoints) -> Iterator[tuple[str, str]]:
    """Yield name and warning of each quadrilateral that is not a rectangle in 3D.

    If one side is matched to another edge in one of the images, such as the frame around a panel, two corners are
    triangulated far behind or in front of the wall, with small stated covariances.

    Args:
        shapes: primitives by their names.
        coordinates: 3D points, named ``name/point``.
    """
    for name, shape in shapes.items():
        if not isinstance(shape, Quadrilateral):
            continue
        corners = coordinates.select(tuple(f'{name}/corner_{k}' for k in range(4)))
        skew, lengths = _skew(corners)
        if skew > 1.0:
            one, other = (f'{100.0 * length:.1f}' for length in lengths)
            text = (
                f'{name}: its opposite sides are {one} and {other} cm long in 3D; a rectangle is probably mismatched: '
                'select another shape'
            )
            yield name, text


def _skew(corners: SpatialPoints) -> tuple[float, tuple[float, float]]:
    """Return the skew, above 1 for anything but a rectangle, and the lengths of the opposite sides [m]."""
    sides = np.roll(corners.positions, -1, axis=0) - corners.positions
    lengths = np.linalg.norm(sides, axis=1)
    along = sides / lengths[:, None]
    covariances = corners.covariances + np.roll(corners.covariances, -1, axis=0)
    variances = np.einsum('ni,nij,nj->n', along, covariances, along)
    (one, other), (variance, other_variance) = lengths.reshape(2, 2), variances.reshape(2, 2)
    gaps, sigmas = np.abs(one - other), np.sqrt(variance + other_variance)
    skews = np.minimum(gaps / (SKEW_MAX * np.maximum(one, other)), gaps / (SKEW_SIGMAS * sigmas))
    worst = int(skews.argmax())
    return float(skews[worst]), (float(one[worst]), float(other[worst]))
