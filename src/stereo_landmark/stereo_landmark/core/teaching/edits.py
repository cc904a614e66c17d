"""Immutable state of a teaching session and its edits: each takes a state and returns the changed state."""

import re
from collections.abc import Collection, Hashable, Mapping, Sequence
from dataclasses import dataclass, field, replace
from functools import reduce

from shirube_core.geometry import SE2
from shirube_core.settings import SettingsError, describe_settings, settings_from_values
from stereo_landmark.core.primitives.primitive import (
    ImageProcessing,
    Primitive,
    PrimitiveKind,
    point_names,
    primitive_kind,
)
from stereo_landmark.core.procedure.taught_place import TaughtPlace
from stereo_landmark.core.stereo_landmark_error import StereoLandmarkError
from stereo_landmark.core.teaching.primitive_selection import Region, TargetSelection

_PLACE_NAME = re.compile(r'[A-Za-z0-9_][A-Za-z0-9_-]{0,63}')
_NAME_MAX = 64
_REGION_MIN = 8.0
"""Minimum side of a region; smaller ones are accidental clicks [px]."""


@dataclass(frozen=True, eq=False)
class TeachingState:
    """State of a place that is being taught; each edit returns a new state.

    Attributes:
        name: name of the place.
        pair: number of the stereo pair used for teaching.
        processing: image processing (paper 4a).
        kinds: kinds of primitives that are shown and can be selected.
        targets: one or more targets.
        active: index of the active target.
        T_map_place: pose of the place in the map, None if unknown.
    """

    name: str = 'place_1'
    pair: int = 0
    processing: ImageProcessing = field(default_factory=ImageProcessing)
    kinds: frozenset[PrimitiveKind] = frozenset({PrimitiveKind.ELLIPSE, PrimitiveKind.QUADRILATERAL})
    targets: tuple[TargetSelection, ...] = (TargetSelection('target_1'),)
    active: int = 0
    T_map_place: SE2 | None = None

    @property
    def target(self) -> TargetSelection:
        """Active target."""
        return self.targets[self.active]

    @property
    def selection_key(self) -> Hashable:
        """Key of all inputs of the procedure check and of the test; equal keys give equal results."""
        targets = tuple((each.name, tuple(each.primitives.items()), each.points) for each in self.targets)
        return self.pair, self.processing, targets

    @property
    def content_key(self) -> Hashable:
        """Key of the content of a saved place; equal keys mean that nothing has to be saved."""
        return self.name, self.T_map_place, self.selection_key


def state_from_place(place: TaughtPlace) -> TeachingState:
    """Return the teaching state of a saved place for further editing; its stereo pair is number 0."""
    selections = []
    for target in place.targets:
        parts = {part.name: part.shape for part in target.primitives}
        selection = TargetSelection(target.name, parts, processing=target.processing)
        names = point_names(selection.primitives.items())
        selections.append(selection.excluding(set(names) - set(target.points)))
    kinds = TeachingState().kinds | {part.kind for target in place.targets for part in target.primitives}
    return TeachingState(place.name, 0, place.processing, kinds, tuple(selections), 0, place.T_map_place)


def rename_place(state: TeachingState, name: str) -> TeachingState:
    """Rename the place.

    Raises:
        StereoLandmarkError: the name is not valid for a file and a frame.
    """
    if not _PLACE_NAME.fullmatch(name):
        raise StereoLandmarkError(f'{name!r} is not a valid place name; use up to 64 letters, digits, _ and -')
    return replace(state, name=name)


def set_map_pose(state: TeachingState, T_map_place: SE2 | None) -> TeachingState:
    """Set the pose of the place in the map; None removes it."""
    return replace(state, T_map_place=T_map_place)


def select_pair(state: TeachingState, pair: int) -> TeachingState:
    """Select another stereo pair for teaching."""
    return replace(state, pair=pair)


def processing_values(processing: ImageProcessing) -> dict[str, float]:
    """Return all values of the image processing by name, such as ``edges.threshold``."""
    names = [description.name for description in describe_settings(ImageProcessing)]
    return {name: float(reduce(getattr, name.split('.'), processing)) for name in names}  # type: ignore[arg-type]


def set_processing(state: TeachingState, name: str, value: float) -> TeachingState:
    """Change one parameter of the image processing, such as ``edges.threshold`` (paper 4a).

    Raises:
        StereoLandmarkError: there is no such setting, or the value is out of range.
    """
    try:
        processing = settings_from_values(ImageProcessing, {**processing_values(state.processing), name: value})
    except SettingsError as fault:
        raise StereoLandmarkError(str(fault)) from fault
    return replace(state, processing=processing)


def reset_processing(state: TeachingState, group: str = '') -> TeachingState:
    """Reset the settings of a group such as ``edges``, or all settings, to their defaults."""
    defaults = {d.name: d.default for d in describe_settings(ImageProcessing) if d.name.startswith(group)}
    values = {**processing_values(state.processing), **defaults}
    return replace(state, processing=settings_from_values(ImageProcessing, values))


def show_kind(state: TeachingState, kind: PrimitiveKind, *, shown: bool) -> TeachingState:
    """Show or hide the primitives of a kind (paper 4b)."""
    return replace(state, kinds=state.kinds | {kind} if shown else state.kinds - {kind})


def add_target(state: TeachingState) -> TeachingState:
    """Add an empty target and activate it."""
    target = TargetSelection(_new_name('target_', {each.name for each in state.targets}))
    return replace(state, targets=(*state.targets, target), active=len(state.targets))


def remove_target(state: TeachingState, number: int) -> TeachingState:
    """Remove a target; the last one is emptied instead."""
    _check_number(number, len(state.targets), 'target')
    rest = (*state.targets[:number], *state.targets[number + 1 :])
    if not rest:
        return replace(state, targets=(TargetSelection(state.targets[0].name),), active=0)
    active = state.active - (state.active > number or state.active == len(rest))
    return replace(state, targets=rest, active=active)


def activate_target(state: TeachingState, number: int) -> TeachingState:
    """Activate another target."""
    _check_number(number, len(state.targets), 'target')
    return replace(state, active=number)


def rename_target(state: TeachingState, number: int, name: str) -> TeachingState:
    """Rename a target.

    Raises:
        StereoLandmarkError: the name is empty, taken, or contains a slash.
    """
    _check_number(number, len(state.targets), 'target')
    others = [target.name for k, target in enumerate(state.targets) if k != number]
    _check_name(name, others)
    targets = list(state.targets)
    targets[number] = replace(targets[number], name=name)
    return replace(state, targets=tuple(targets))


def set_region(state: TeachingState, region: Region | None) -> TeachingState:
    """Set the region of the left image that contains the target (paper 4b); None for the whole image.

    Raises:
        StereoLandmarkError: the region is too small.
    """
    if region is not None and min(region.right - region.left, region.bottom - region.top) < _REGION_MIN:
        raise StereoLandmarkError('the region is too small; drag from one corner of the object to the other')
    if region == state.target.region:
        return state
    return _with_target(state, replace(state.target, region=region))


def add_primitive(state: TeachingState, shape: Primitive) -> TeachingState:
    """Add a primitive to the target, last in the order of detection."""
    target = state.target
    name = _new_name(f'{primitive_kind(shape).value} ', target.primitives)
    return _with_primitives(state, {**target.primitives, name: shape}, target.excluded_points)


def remove_primitive(state: TeachingState, name: str) -> TeachingState:
    """Remove a primitive from the target."""
    target = state.target
    _check_primitive(target, name)
    rest = {other: shape for other, shape in target.primitives.items() if other != name}
    return _with_primitives(state, rest, target.excluded_points)


def remove_primitives(state: TeachingState, refused: Sequence[Collection[str]]) -> TeachingState:
    """Remove primitives from all targets, by their names for each target; without any nothing changes."""
    targets = tuple(
        replace(
            target, primitives={name: shape for name, shape in target.primitives.items() if name not in names}
        ).excluding(target.excluded_points)
        for target, names in zip(state.targets, refused, strict=True)
    )
    return replace(state, targets=targets) if any(refused) else state


def rename_primitive(state: TeachingState, old: str, new: str) -> TeachingState:
    """Rename a primitive of the target.

    Raises:
        StereoLandmarkError: it does not exist, or the new name is empty, taken, or contains a slash.
    """
    target = state.target
    _check_primitive(target, old)
    _check_name(new, [name for name in target.primitives if name != old])
    primitives = {new if name == old else name: shape for name, shape in target.primitives.items()}
    excluded_points = frozenset(
        f'{new}/{point.removeprefix(f"{old}/")}' if point.startswith(f'{old}/') else point
        for point in target.excluded_points
    )
    return _with_primitives(state, primitives, excluded_points)


def move_primitive(state: TeachingState, name: str, place: int) -> TeachingState:
    """Move a primitive in the order of detection (paper 4b): 0 for the first, beyond the end for the last."""
    target = state.target
    _check_primitive(target, name)
    names = [other for other in target.primitives if other != name]
    names.insert(max(place, 0), name)
    moved = {other: target.primitives[other] for other in names}
    return _with_primitives(state, moved, target.excluded_points)


def set_points_used(state: TeachingState, points: Sequence[str], *, used: bool) -> TeachingState:
    """Include or exclude points, named ``primitive/point``, in the pose estimate (paper 4c).

    Raises:
        StereoLandmarkError: a primitive does not belong to the target.
    """
    target, named = state.target, frozenset(points)
    for point in points:
        _check_primitive(target, point.rpartition('/')[0])
    excluded_points = target.excluded_points - named if used else target.excluded_points | named
    return _with_primitives(state, target.primitives, excluded_points)


def _with_primitives(
    state: TeachingState, primitives: Mapping[str, Primitive], excluded_points: frozenset[str]
) -> TeachingState:
    return _with_target(state, replace(state.target, primitives=primitives).excluding(excluded_points))


def _with_target(state: TeachingState, target: TargetSelection) -> TeachingState:
    targets = (*state.targets[: state.active], target, *state.targets[state.active + 1 :])
    return replace(state, targets=targets)


def _new_name(prefix: str, taken: Collection[str]) -> str:
    """Return the first name with a number that is not taken."""
    return next(f'{prefix}{k}' for k in range(1, len(taken) + 2) if f'{prefix}{k}' not in taken)


def _check_primitive(target: TargetSelection, name: str) -> None:
    if name not in target.primitives:
        known = ', '.join(target.primitives) or 'none yet'
        raise StereoLandmarkError(f'{target.name} has no primitive {name}; it has {known}')


def _check_number(number: int, count: int, what: str) -> None:
    if not 0 <= number < count:
        raise StereoLandmarkError(f'there is no {what} {number + 1}, there are {count}')


def _check_name(name: str, taken: Sequence[str]) -> None:
    if not name.strip() or '/' in name or not name.isprintable() or len(name) > _NAME_MAX:
        raise StereoLandmarkError(
            f'{name!r} is not a valid name; use up to {_NAME_MAX} printable characters without a slash'
        )
    if name in taken:
        raise StereoLandmarkError(f'{name} is taken; choose another name')
