"""Teaches a place from a stereo pair and the selected primitives (paper 4)."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import replace

import numpy as np

from shirube_core.geometry import SE2
from stereo_landmark.core.arrays import Floats
from stereo_landmark.core.primitives.ellipse import Ellipse
from stereo_landmark.core.primitives.primitive import (
    ImageProcessing,
    Primitive,
    PrimitiveKind,
    drop_covariance,
    point_names,
    primitive_kind,
)
from stereo_landmark.core.procedure.stereo_view import (
    NamedPair,
    StereoView,
    align_pair,
    detect_scene,
    refine_pair,
    stereo_points,
)
from stereo_landmark.core.procedure.taught_place import TaughtPlace, TaughtPrimitive, TaughtTarget, wall_normal
from stereo_landmark.core.settings import PlaceSettings
from stereo_landmark.core.stereo import (
    SpatialPoints,
    StereoImages,
    StereoPoints,
    add_calibration_noise,
    is_in_same_row,
    is_measurable,
)
from stereo_landmark.core.stereo_landmark_error import StereoLandmarkError
from stereo_landmark.core.teaching.primitive_selection import TargetSelection, find_same

CONTEXT_LANDMARKS_MAX = 40
CONTEXT_LANDMARK_DISTANCE_MIN = 16.0
"""Minimum distance between context landmarks, so that each object counts once [px]."""
CONTEXT_LANDMARK_KINDS = (PrimitiveKind.QUADRILATERAL, PrimitiveKind.ELLIPSE, PrimitiveKind.CORNER)
"""Kinds of context landmarks, the most distinctive first."""

NOT_DETECTED = 'it is not detected with this image processing; remove it, or undo the change'


class Teacher:
    """Teaches one place from one stereo pair.

    Args:
        view: stereo view with all kinds of primitives.
        processing: image processing that detected the primitives.
        pixel_sigma: calibration error, which also affects the taught points [px].
    """

    def __init__(
        self, view: StereoView, processing: ImageProcessing, pixel_sigma: float = PlaceSettings.pixel_sigma
    ) -> None:
        self.view = view
        self.processing = processing
        self._pixel_sigma = pixel_sigma
        self._same: dict[Primitive, Primitive | None] = {}
        self._measured: dict[Primitive, tuple[Primitive, Primitive] | str] = {}
        self._others: dict[ImageProcessing, Teacher] = {}

    def with_processing(self, processing: ImageProcessing | None) -> Teacher:
        """Return the teacher of the same pair with the image processing of a target (paper 3.2); itself for None."""
        if processing is None or processing == self.processing:
            return self
        if processing not in self._others:
            view = self.view
            left, right = (detect_scene(each.image, processing) for each in (view.left, view.right))
            other = Teacher(replace(view, left=left, right=right), processing, self._pixel_sigma)
            self._others[processing] = other
        return self._others[processing]

    def find_same(self, shape: Primitive) -> Primitive | None:
        """Return a primitive of another detection of the left image as it is detected now, None if it is not."""
        if shape not in self._same:
            self._same[shape] = find_same(shape, self.view.left.kinds[primitive_kind(shape)])
        return self._same[shape]

    def measure(self, chosen: Primitive) -> tuple[Primitive, Primitive]:
        """Return a primitive detected in the left image, refined in both grey images; each is measured once.

        Raises:
            StereoLandmarkError: the right image has no match, or an outline cannot be measured.
        """
        if fault := self.fault(chosen):
            raise StereoLandmarkError(fault)
        return self._measured[chosen]  # type: ignore[return-value]

    def _measure_or_fault(self, chosen: Primitive) -> tuple[Primitive, Primitive] | str:
        match = self._find_match(chosen)
        if match is None:
            return 'it is not found in the right image; select another shape'
        images = self.view.left.image, self.view.right.image
        measured = refine_pair(*align_pair(chosen, chosen, match), images)
        if measured is None:
            return 'its outline is not clear enough in both images; select another shape'
        points = stereo_points([('it', *measured)])
        if not is_in_same_row(points, self._pixel_sigma).all():
            apart = float(np.median(np.abs(points.pixels[:, 3] - points.pixels[:, 1])))
            return (
                f'the cameras show it at different heights ({apart:.2f} px), so it is mismatched; select another '
                'shape, or recalibrate the cameras as a pair if many shapes are'
            )
        if not is_measurable(points, self.view.rig).all():
            return 'it is too far away; select a nearer shape'
        return measured

    def can_measure(self, chosen: Primitive) -> bool:
        """Return whether a primitive detected in the left image can be measured in both."""
        return not self.fault(chosen)

    def fault(self, chosen: Primitive) -> str:
        """Return why a primitive detected in the left image cannot be measured, empty if it can; each is tried once."""
        if chosen not in self._measured:
            self._measured[chosen] = self._measure_or_fault(chosen)
        measured = self._measured[chosen]
        return measured if isinstance(measured, str) else ''

    def drop_refused(self, selections: Iterable[TargetSelection]) -> tuple[list[TargetSelection], list[str]]:
        """Return the selections without primitives that cannot be measured, and a line for each of these.

        Raises:
            StereoLandmarkError: nothing is left.
        """
        usable, lines = [], []
        for selection in selections:
            kept = {}
            for part, shape in selection.primitives.items():
                try:
                    self.measure_named(selection, part)
                    kept[part] = shape
                except StereoLandmarkError as fault:
                    lines.append(f'{fault}; the place is taught without it')
            points = selection.points and tuple(p for p in selection.points if p.rpartition('/')[0] in kept)
            if len(kept) == len(selection.primitives):
                usable.append(selection)
            elif kept and points != ():
                usable.append(replace(selection, primitives=kept, points=points))
        if lines and not usable:
            raise StereoLandmarkError(f'no primitive can be measured: {"; ".join(lines)}')
        return usable, lines

    def coordinates(self, points: StereoPoints) -> SpatialPoints:
        """Triangulate points into the place's frame.

        Raises:
            StereoLandmarkError: a point is too far away.
        """
        too_far = np.flatnonzero(~is_measurable(points, self.view.rig))
        if len(too_far):
            raise StereoLandmarkError(f'{points.names[too_far[0]]} is too far away to be measured; exclude it')
        return self.view.spatial_points(add_calibration_noise(points, self._pixel_sigma))

    def teach(self, name: str, selections: Sequence[TargetSelection], T_map_place: SE2 | None = None) -> TaughtPlace:
        """Return the taught place.

        Args:
            name: name of the place.
            selections: selected targets.
            T_map_place: pose of the place in the map, None if unknown.

        Raises:
            StereoLandmarkError: a primitive cannot be measured, or names are duplicate or missing.
        """
        if not selections:
            raise StereoLandmarkError(f'place {name} has no target; select primitives for one')
        # Targets: primitives in their order of detection (4b), measured in both images.
        pairs: list[NamedPair] = []
        targets: list[TaughtTarget] = []
        for selection in selections:
            named_pairs = [
                (f'{selection.name}/{part}', *self.measure_named(selection, part)) for part in selection.primitives
            ]
            pairs += named_pairs
            targets.append(self._target(selection, named_pairs))
        _check_names([target.name for target in targets])
        # Corresponding points with their 3D coordinates (4c).
        coordinates = self.coordinates(stereo_points(pairs))
        # Other primitives around the targets, which disambiguate similar targets (not in the paper).
        context_landmarks = self._find_context_landmarks([left for _, left, _ in pairs])
        # Walls of the circles, for the projection of their centres (not in the paper).
        around = np.vstack([coordinates.positions, *(each.position[None] for each in context_landmarks)])
        return TaughtPlace(
            name,
            self.view.rig,
            tuple(_add_wall_normals(target, around) for target in targets),
            coordinates,
            context_landmarks,
            self.processing,
            T_map_place,
            StereoImages(self.view.left.image, self.view.right.image, self.view.tilt),
        )

    def measure_named(self, selection: TargetSelection, part: str) -> tuple[Primitive, Primitive]:
        """Return a selected primitive, measured in both images; errors as of `measure`."""
        teacher, shape = self.with_processing(selection.processing), selection.primitives[part]
        chosen = teacher.find_same(shape)
        try:
            if chosen is None:
                raise StereoLandmarkError(NOT_DETECTED)
            return teacher.measure(chosen)
        except StereoLandmarkError as fault:
            raise StereoLandmarkError(f'target {selection.name}, primitive {part}: {fault}') from fault

    def _target(self, selection: TargetSelection, pairs: Sequence[NamedPair]) -> TaughtTarget:
        if not pairs:
            raise StereoLandmarkError(f'target {selection.name} has no shape; select one or more')
        primitives = tuple(
            TaughtPrimitive(part, drop_covariance(left), self._position(left, right))
            for part, (_, left, right) in zip(selection.primitives, pairs, strict=True)
        )
        names = point_names(selection.primitives.items())
        points = names if selection.points is None else selection.points
        if not points:
            raise StereoLandmarkError(
                f'target {selection.name} has no point for the pose; use one or more of its points'
            )
        for point in points:
            if point not in names:
                raise StereoLandmarkError(
                    f'target {selection.name} has no point {point}; its points are {", ".join(names)}'
                )
        return TaughtTarget(selection.name, primitives, points, selection.processing)

    def _position(self, left: Primitive, right: Primitive) -> Floats:
        """Return the centre of a primitive in the place's frame, shape (3,) [m]."""
        (position,) = self.coordinates(_centre(left, right)).positions
        return position

    def _find_match(self, chosen: Primitive) -> Primitive | None:
        """Return the match of a left primitive in the right image, None if there is none."""
        kind = primitive_kind(chosen)
        here, there = self.view.detected_pair(kind)
        number = next(i for i, primitive in enumerate(here.primitives) if primitive is chosen)
        match = int(self.view.match_indices(kind)[number])
        return None if match < 0 else there.primitives[match]

    def _find_context_landmarks(self, taught: Iterable[Primitive]) -> tuple[TaughtPrimitive, ...]:
        """Return context landmarks: other stereo-matched primitives, the most distinctive one at each position."""
        taken = list(taught)
        found: list[TaughtPrimitive] = []
        for kind in CONTEXT_LANDMARK_KINDS:
            for primitive in self.view.left.kinds[kind].primitives:
                if len(found) == CONTEXT_LANDMARKS_MAX:
                    return tuple(found)
                if any(_may_be_same_object(primitive, other) for other in taken):
                    continue
                match = self._find_match(primitive)
                if match is not None and is_measurable(_centre(primitive, match), self.view.rig).all():
                    taken.append(primitive)
                    position = self._position(primitive, match)
                    name = f'{kind.value} {len(found) + 1}'
                    found.append(TaughtPrimitive(name, drop_covariance(primitive), position))
        return tuple(found)


def _centre(left: Primitive, right: Primitive) -> StereoPoints:
    """Return the unrefined centre of a primitive."""
    pixels = np.array([[*left.centre, *right.centre]])
    return StereoPoints(('centre',), pixels, np.eye(4)[None])


def _add_wall_normals(target: TaughtTarget, around: Floats) -> TaughtTarget:
    """Return a target whose circles have wall normals, estimated from surrounding points, shape (n, 3) [m]."""
    primitives = tuple(
        replace(each, normal=wall_normal(each.position, around)) if each.kind is PrimitiveKind.ELLIPSE else each
        for each in target.primitives
    )
    return replace(target, primitives=primitives)


def _may_be_same_object(one: Primitive, other: Primitive) -> bool:
    """Return whether two primitives may belong to one object, such as a corner on the outline of a plate."""
    positions, others = (np.array([point.position for point in each.image_points().values()]) for each in (one, other))
    gaps = np.linalg.norm(positions[:, None] - others[None], axis=2)
    radii = [float(each.semi_axes[0]) if isinstance(each, Ellipse) else 0.0 for each in (one, other)]
    # Ellipses that do not overlap are different objects: the next meter in a row is the most informative.
    apart = 0.0 if all(radii) else CONTEXT_LANDMARK_DISTANCE_MIN
    return bool(gaps.min() - sum(radii) < apart)


def _check_names(names: Sequence[str]) -> None:
    for name in names:
        if names.count(name) > 1:
            raise StereoLandmarkError(f'two targets are called {name}; names must be unique')
