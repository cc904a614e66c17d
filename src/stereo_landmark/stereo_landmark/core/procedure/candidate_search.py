"""Finds and triangulates detected primitives that are similar to a taught one."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from stereo_landmark.core.arrays import Floats, Ints, Masks
from stereo_landmark.core.primitives.primitive import (
    PrimitiveKind,
    Tolerances,
    shape_differences,
    shape_vectors,
)
from stereo_landmark.core.primitives.quadrilateral import order_corner_pairs
from stereo_landmark.core.procedure.stereo_view import DetectedPrimitives, StereoView
from stereo_landmark.core.procedure.taught_place import TaughtPrimitive
from stereo_landmark.core.stereo import StereoRig


@dataclass(frozen=True)
class StereoCandidates:
    """Detected stereo pairs that are similar to one taught primitive.

    Attributes:
        left: indices among the primitives of the kind in the left image, shape (n,).
        right: indices in the right image, shape (n,).
        centres: u, v left and u right of the centres, shape (n, 3) [px].
        positions: centres in the gravity-aligned base frame, shape (n, 3) [m].
        points: invariant points in the order of the taught one's, u, v left and u, v right, shape (n, p, 4) [px].
    """

    left: Ints
    right: Ints
    centres: Floats
    positions: Floats
    points: Floats

    def __len__(self) -> int:
        return len(self.left)


def find_stereo_candidates(
    taught: Sequence[TaughtPrimitive], view: StereoView, depths: Floats, tolerances: Tolerances
) -> list[StereoCandidates]:
    """Find the stereo candidates of each taught primitive.

    Args:
        taught: k taught primitives.
        view: stereo view.
        depths: smallest and largest accepted depth of each, shape (k, 2) [m].
        tolerances: tolerances of the shape comparison.
    """
    similar = similar_primitives(taught, view.left.kinds, tolerances)
    return [
        _find_candidates(each, np.flatnonzero(row), view, limits)
        for each, row, limits in zip(taught, similar, depths, strict=True)
    ]


def similar_primitives(
    taught: Sequence[TaughtPrimitive], kinds: dict[PrimitiveKind, DetectedPrimitives], tolerances: Tolerances
) -> list[Masks]:
    """Return for each taught primitive the mask of primitives within the tolerances, each of shape (n,)."""
    rows: dict[int, Masks] = {}
    for kind, detected in kinds.items():
        indices = [k for k, each in enumerate(taught) if each.kind is kind]
        if indices:
            shapes = shape_vectors(kind, [taught[k].shape for k in indices])
            rows.update(
                zip(
                    indices,
                    shape_differences(kind, detected.shape_vectors, shapes, tolerances) <= 1.0,
                    strict=True,
                )
            )
    return [rows[k] for k in range(len(taught))]


def _find_candidates(
    taught: TaughtPrimitive, similar: Ints, view: StereoView, depths: Floats
) -> StereoCandidates:
    here, there = view.detected_pair(taught.kind)
    right = view.match_indices(taught.kind)[similar]
    left, right = similar[right >= 0], right[right >= 0]
    pixels = np.column_stack([here.centres[left], there.centres[right]])
    points = _triangulate(pixels, view.rig)
    kept = (points[:, 2] >= depths[0]) & (points[:, 2] <= depths[1])
    positions = points[kept] @ view.camera.rotation.T + view.camera.position
    left, right, pixels = left[kept], right[kept], pixels[kept]
    return StereoCandidates(
        left, right, pixels[:, :3], positions, _invariant_points(taught, left, right, view, pixels)
    )


def _invariant_points(
    taught: TaughtPrimitive, left: Ints, right: Ints, view: StereoView, centres: Floats
) -> Floats:
    """Return the corners of quadrilaterals, shape (n, 4, 4), and the centres of other kinds, shape (n, 1, 4) [px]."""
    if taught.kind is not PrimitiveKind.QUADRILATERAL:
        return centres[:, None]
    here, there = view.detected_pair(taught.kind)
    (first,) = shape_vectors(taught.kind, [taught.shape])
    corners = order_corner_pairs(here.shape_vectors[left], there.shape_vectors[right], first)
    return np.asarray(corners + centres[:, None])


def _triangulate(pixels: Floats, rig: StereoRig) -> Floats:
    """Triangulate u, v left and u, v right, shape (n, 4) [px], into the left optical frame, shape (n, 3) [m]."""
    left = rig.left
    z = left.fx * rig.baseline / ((pixels[:, 0] - left.cx) - (pixels[:, 2] - rig.right.cx))
    x = (pixels[:, 0] - left.cx) / left.fx * z
    y = (0.5 * (pixels[:, 1] + pixels[:, 3]) - left.cy) / left.fy * z
    return np.column_stack([x, y, z])
