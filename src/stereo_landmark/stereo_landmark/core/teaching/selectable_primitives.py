"""Detected primitives that can be selected for a target (paper 4b)."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass

import numpy as np

from stereo_landmark.core.primitives.primitive import (
    Primitive,
    PrimitiveKind,
    Tolerances,
    difference,
    primitive_kind,
    primitive_size,
)
from stereo_landmark.core.procedure.stereo_view import DetectedScene, StereoView
from stereo_landmark.core.teaching.teaching_state import Region

_SAME_CENTRE = 3.0
"""Maximum distance of the same primitive after a change of the image processing [px],"""
_SAME_SIZE = 0.15
"""and maximum relative difference of its size."""


@dataclass(frozen=True, eq=False)
class SelectablePrimitive:
    """A selectable primitive of the left image.

    Attributes:
        kind: kind of the primitive.
        number: index among the primitives of its kind.
        shape: detected shape.
        depth: depth of its centre [m], None without a match in the right image.
    """

    kind: PrimitiveKind
    number: int
    shape: Primitive
    depth: float | None


def selectable_primitives(
    view: StereoView, kinds: Iterable[PrimitiveKind], region: Region | None
) -> list[SelectablePrimitive]:
    """Return the primitives detected in a region of the left image; None for the whole image."""
    found = []
    for kind in sorted(kinds, key=list(PrimitiveKind).index):
        for number, shape in enumerate(view.left.kinds[kind].primitives):
            if region is None or region.contains(np.vstack(shape.outline())):
                found.append(SelectablePrimitive(kind, number, shape, _depth(view, kind, number)))
    return found


def find_same_primitive(shape: Primitive, scene: DetectedScene) -> Primitive | None:
    """Return the same primitive in another detection result of the same image, None if it is not detected."""
    detected = scene.kinds[primitive_kind(shape)]
    if any(each is shape for each in detected.primitives):
        return shape
    if not detected.primitives:
        return None
    neighbours = detected.kd_tree.query_ball_point(shape.centre, _SAME_CENTRE)
    similar = [
        detected.primitives[i]
        for i in neighbours
        if abs(primitive_size(detected.primitives[i]) / primitive_size(shape) - 1.0) < _SAME_SIZE
        and difference(detected.primitives[i], shape, Tolerances()) <= 1.0
    ]
    return min(
        similar,
        key=lambda each: (
            float(np.hypot(*(each.centre - shape.centre))) + abs(primitive_size(each) - primitive_size(shape))
        ),
        default=None,
    )


def _depth(view: StereoView, kind: PrimitiveKind, number: int) -> float | None:
    match = int(view.match_indices(kind)[number])
    if match < 0:
        return None
    here, there = view.detected_pair(kind)
    left, right = view.rig.left, view.rig.right
    disparity = (here.centres[number, 0] - left.cx) - (there.centres[match, 0] - right.cx)
    return float(left.fx * view.rig.baseline / disparity)
