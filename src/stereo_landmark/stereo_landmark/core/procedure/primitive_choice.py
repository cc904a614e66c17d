"""Selects detected primitives by position, size and order instead of by mouse (paper 4b)."""

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
"""Maximum distance of the selected primitive from the given pixel [px]."""


ANY_SIZE = (0.0, math.inf)


class Order(Enum):
    """Sort order of the primitives of a region."""

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
    """Selects the primitive nearest to a pixel.

    Attributes:
        kind: kind of the primitive.
        place: u and v near its centre [px].
        sizes: smallest and largest `size_of`, e.g. to separate the inner from the outer edge of a rim [px].
        name: name of the selected primitive; the kind and a number if empty.
    """

    kind: Kind
    place: tuple[float, float]
    sizes: tuple[float, float] = ANY_SIZE
    name: str = ''

    def found_in(self, scene: DetectedScene) -> list[Primitive]:
        """Return the primitive nearest to the pixel.

        Raises:
            StereoLandmarkError: no primitive is near.
        """
        among = _of_size(scene, self.kind, self.sizes)
        centres = np.array([primitive.centre for primitive in among]).reshape(-1, 2)
        offsets = np.hypot(*(centres - self.place).T)
        if not len(offsets) or offsets.min() > NEAR:
            where = f'{self.place[0]:g}, {self.place[1]:g}'
            nearest = 'there is none of this size in the image'
            if len(offsets):
                u, v = centres[int(offsets.argmin())]
                nearest = f'the nearest is at {u:.0f}, {v:.0f}'
            raise StereoLandmarkError(f'no {self.kind.value} near {where}, {nearest}; correct near')
        return [among[int(offsets.argmin())]]


@dataclass(frozen=True)
class RegionChoice:
    """Selects all primitives of a kind in a region.

    Attributes:
        kind: kind of the primitives.
        region: left, top, right, bottom of the rectangle that contains their centres [px].
        sizes: smallest and largest size [px].
        order: sort order.
        count: exact number of selected primitives, the first in the order; None for all.
        name: name prefix of the selected primitives; the kind if empty.
    """

    kind: Kind
    region: tuple[float, float, float, float]
    sizes: tuple[float, float] = ANY_SIZE
    order: Order = Order.LEFT_TO_RIGHT
    count: int | None = None
    name: str = ''

    def found_in(self, scene: DetectedScene) -> list[Primitive]:
        """Return the primitives in the sort order.

        Raises:
            StereoLandmarkError: there are fewer than requested, or none.
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
    """Return the selected primitives by name, in the order of the selections.

    Named primitives keep their names; others are numbered, ``meter 1``, ``meter 2``.

    Raises:
        StereoLandmarkError: a selection matches nothing, or a name or a primitive is selected twice.
    """
    named: dict[str, Primitive] = {}
    for choice in choices:
        for number, primitive in enumerate(choice.found_in(scene), start=1):
            if any(primitive is other for other in named.values()):
                raise StereoLandmarkError(
                    f'{choice.kind.value} at {primitive.centre[0]:.0f}, {primitive.centre[1]:.0f} selected twice; '
                    'remove one of the entries'
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
        raise StereoLandmarkError(f'two primitives are called {name}; names must be unique')
    return name
