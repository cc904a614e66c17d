"""Detected primitives that can be selected for a target (paper 4b)."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass

import numpy as np

from stereo_landmark.core.procedure.detected_scene import DetectedScene
from stereo_landmark.core.procedure.primitive import Kind, Primitive, Tolerances, difference, kind_of, size_of
from stereo_landmark.core.procedure.stereo_view import StereoView
from stereo_landmark.core.teaching.outline import outline_of
from stereo_landmark.core.teaching.teaching_state import Region

_SAME_CENTRE = 3.0
"""Maximum distance of the same primitive after a change of the image processing [px],"""
_SAME_SIZE = 0.15
"""and maximum relative difference of its size."""


@dataclass(frozen=True, eq=False)
class FoundPrimitive:
    """A selectable primitive of the left image.

    Attributes:
        kind: kind of the primitive.
        number: index among the primitives of its kind.
        shape: detected shape.
        depth: depth of its centre [m], None without a match in the right image.
    """

    kind: Kind
    number: int
    shape: Primitive
    depth: float | None


def found_primitives(view: StereoView, kinds: Iterable[Kind], region: Region | None) -> list[FoundPrimitive]:
    """Return the primitives detected in a region of the left image; None for the whole image."""
    found = []
    for kind in sorted(kinds, key=list(Kind).index):
        for number, shape in enumerate(view.left.kinds[kind].primitives):
            if region is None or region.holds(np.vstack(outline_of(shape))):
                found.append(FoundPrimitive(kind, number, shape, _depth(view, kind, number)))
    return found


def found_again(shape: Primitive, scene: DetectedScene) -> Primitive | None:
    """Return the same primitive in another detection result of the same image, None if it is not detected."""
    among = scene.kinds[kind_of(shape)]
    if any(each is shape for each in among.primitives):
        return shape
    if not among.primitives:
        return None
    near = among.tree.query_ball_point(shape.centre, _SAME_CENTRE)
    alike = [
        among.primitives[i]
        for i in near
        if abs(size_of(among.primitives[i]) / size_of(shape) - 1.0) < _SAME_SIZE
        and difference(among.primitives[i], shape, Tolerances()) <= 1.0
    ]
    return min(
        alike,
        key=lambda each: float(np.hypot(*(each.centre - shape.centre))) + abs(size_of(each) - size_of(shape)),
        default=None,
    )


def _depth(view: StereoView, kind: Kind, number: int) -> float | None:
    partner = int(view.partners_of(kind)[number])
    if partner < 0:
        return None
    here, there = view.both(kind)
    left, right = view.rig.left, view.rig.right
    disparity = (here.centres[number, 0] - left.cx) - (there.centres[partner, 0] - right.cx)
    return float(left.fx * view.rig.baseline / disparity)
