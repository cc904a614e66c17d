"""Choosing detected primitives by words instead of by hand (paper 4b)."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass
from enum import Enum

import numpy as np

from stereo_landmark.core.procedure.detected_scene import DetectedScene
from stereo_landmark.core.procedure.primitive import Kind, Primitive, size_of
from stereo_landmark.core.stereo_landmark_error import StereoLandmarkError

NEAR = 20.0
"""A primitive that is farther from the given place is another one [px]."""


ANY_SIZE = (0.0, math.inf)


class Order(Enum):
    """In which primitives of a region are looked for."""

    LEFT_TO_RIGHT = 'left_to_right'
    RIGHT_TO_LEFT = 'right_to_left'
    TOP_TO_BOTTOM = 'top_to_bottom'
    BOTTOM_TO_TOP = 'bottom_to_top'
    LARGEST_FIRST = 'largest_first'


_RANKS: dict[Order, Callable[[Primitive], float]] = {
    Order.LEFT_TO_RIGHT: lambda primitive: float(primitive.centre[0]),
    Order.RIGHT_TO_LEFT: lambda primitive: -float(primitive.centre[0]),
    Order.TOP_TO_BOTTOM: lambda primitive: float(primitive.centre[1]),
    Order.BOTTOM_TO_TOP: lambda primitive: -float(primitive.centre[1]),
    Order.LARGEST_FIRST: lambda primitive: -size_of(primitive),
}


@dataclass(frozen=True)
class NearChoice:
    """One primitive, by where it is.

    Attributes:
        kind: of the primitive.
        place: u and v near its centre [px].
        sizes: smallest and largest, as `size_of` tells them; they tell a rim's inside from its outside [px].
        name: that it gets; the kind and a number if empty.
    """

    kind: Kind
    place: tuple[float, float]
    sizes: tuple[float, float] = ANY_SIZE
    name: str = ''

    def found_in(self, scene: DetectedScene) -> list[Primitive]:
        """Return the primitive nearest to the place.

        Raises:
            StereoLandmarkError: there is none near.
        """
        among = _of_size(scene, self.kind, self.sizes)
        centres = np.array([primitive.centre for primitive in among]).reshape(-1, 2)
        offsets = np.hypot(*(centres - self.place).T)
        if not len(offsets) or offsets.min() > NEAR:
            where = f'{self.place[0]:g}, {self.place[1]:g}'
            nearest = 'there is none of these sizes in the image'
            if len(offsets):
                u, v = centres[int(offsets.argmin())]
                nearest = f'the nearest is at {u:.0f}, {v:.0f}'
            raise StereoLandmarkError(f'no {self.kind.value} near {where}, {nearest}; correct near')
        return [among[int(offsets.argmin())]]


@dataclass(frozen=True)
class RegionChoice:
    """All primitives of a kind in a region.

    Attributes:
        kind: of the primitives.
        region: left, top, right, bottom; their centres are inside [px].
        sizes: smallest and largest [px].
        order: in which they are taken.
        count: as many there must be, and no more are taken; None for any number.
        name: that they get, with a number; the kind if empty.
    """

    kind: Kind
    region: tuple[float, float, float, float]
    sizes: tuple[float, float] = ANY_SIZE
    order: Order = Order.LEFT_TO_RIGHT
    count: int | None = None
    name: str = ''

    def found_in(self, scene: DetectedScene) -> list[Primitive]:
        """Return the primitives in their order.

        Raises:
            StereoLandmarkError: there are fewer than asked for, or none.
        """
        left, top, right, bottom = self.region
        found = [
            primitive
            for primitive in _of_size(scene, self.kind, self.sizes)
            if left <= primitive.centre[0] <= right and top <= primitive.centre[1] <= bottom
        ]
        if len(found) < (self.count or 1):
            raise StereoLandmarkError(
                f'{len(found)} of kind {self.kind.value} in the region, {self.count or 1} are needed; '
                'correct region or image_processing'
            )
        return sorted(found, key=_RANKS[self.order])[: self.count]


Choice = NearChoice | RegionChoice


def named_primitives(choices: list[Choice], scene: DetectedScene) -> dict[str, Primitive]:
    """Return what is chosen by name, in the order of the choices.

    A primitive that has a name of its own keeps it; others are numbered, ``meter 1``, ``meter 2``.

    Raises:
        StereoLandmarkError: a choice finds nothing, a name or a primitive is chosen twice.
    """
    named: dict[str, Primitive] = {}
    for choice in choices:
        for number, primitive in enumerate(choice.found_in(scene), start=1):
            if any(primitive is other for other in named.values()):
                raise StereoLandmarkError(
                    f'{choice.kind.value} at {primitive.centre[0]:.0f}, {primitive.centre[1]:.0f} is chosen twice; '
                    'leave one of the choices out'
                )
            named[_name(choice, number, named)] = primitive
    return named


def _of_size(scene: DetectedScene, kind: Kind, sizes: tuple[float, float]) -> list[Primitive]:
    return [each for each in scene.kinds[kind].primitives if sizes[0] <= size_of(each) <= sizes[1]]


def _name(choice: Choice, number: int, taken: dict[str, Primitive]) -> str:
    if isinstance(choice, NearChoice) and choice.name:
        name = choice.name
    elif choice.name:
        name = f'{choice.name} {number}'
    else:
        number = 1 + sum(key.startswith(f'{choice.kind.value} ') for key in taken)
        name = f'{choice.kind.value} {number}'
    if name in taken:
        raise StereoLandmarkError(f'two primitives are called {name}; give each a name of its own')
    return name
