"""Immutable state of a teaching session."""

from __future__ import annotations

from collections.abc import Hashable
from dataclasses import dataclass, field

from shirube_core.geometry import SE2
from stereo_landmark.core.primitives.primitive import ImageProcessing, PrimitiveKind, point_names
from stereo_landmark.core.procedure.taught_place import TaughtPlace
from stereo_landmark.core.teaching.primitive_selection import TargetSelection


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
        selection = TargetSelection(target.name, {part.name: part.shape for part in target.primitives})
        names = point_names(selection.primitives.items())
        selections.append(selection.excluding(set(names) - set(target.points)))
    kinds = TeachingState().kinds | {part.kind for target in place.targets for part in target.primitives}
    return TeachingState(place.name, 0, place.processing, kinds, tuple(selections), 0, place.T_map_place)
