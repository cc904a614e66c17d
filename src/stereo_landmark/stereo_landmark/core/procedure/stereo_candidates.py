"""Which detected primitives may be a taught one, and where they are in space."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from stereo_landmark.core.place.stereo_rig import StereoRig
from stereo_landmark.core.procedure.detected_scene import DetectedKind
from stereo_landmark.core.procedure.primitive import Primitive, Tolerances, difference, kind_of, size_of
from stereo_landmark.core.procedure.stereo_view import StereoView

ROWS_APART = 2.0
"""Rectified images show a point in the same row, and detection is about a pixel off [px]."""
SIZE_RATIO = 1.25
"""Both cameras see nearly the same size."""
SAME_SHAPE = 0.6
"""Of the taught tolerances: both cameras see nearly the same shape."""


@dataclass(frozen=True)
class StereoCandidates:
    """Detected primitives that may be one taught primitive.

    Attributes:
        left: numbers among those of its kind in the left image, shape (n,).
        right: the same in the right image, shape (n,).
        positions: of their centres in the level base frame, shape (n, 3) [m].
        differences: from the taught shape, shape (n,), 1 just tolerated.
    """

    left: NDArray[np.int64]
    right: NDArray[np.int64]
    positions: NDArray[np.float64]
    differences: NDArray[np.float64]

    def __len__(self) -> int:
        return len(self.left)


def alike(taught: Primitive, among: DetectedKind, tolerances: Tolerances) -> list[tuple[int, float]]:
    """Return the number and the difference of each primitive that is within the tolerances."""
    largest = 1.0 + max(
        tolerances.ellipse.axes, tolerances.quadrilateral.size, tolerances.parallel_lines.width
    )
    ratios = among.sizes / size_of(taught) if len(among.primitives) else np.empty(0)
    near = np.flatnonzero((ratios < largest) & (ratios > 1.0 / largest))
    rated = [(int(i), difference(among.primitives[i], taught, tolerances)) for i in near]
    return [(i, apart) for i, apart in rated if apart <= 1.0]


def stereo_candidates(
    taught: Primitive, view: StereoView, depths: tuple[float, float], tolerances: Tolerances
) -> StereoCandidates:
    """Find what both images show that may be a taught primitive.

    Args:
        taught: as seen by the left camera when it was taught.
        view: both images.
        depths: smallest and largest depth that it may have [m].
        tolerances: how far it may differ.
    """
    here, there = view.both(kind_of(taught))
    rows: list[tuple[int, int, float]] = []
    for i, apart in alike(taught, here, tolerances):
        rows += [(i, j, apart) for j in _partners(here, i, there, view.rig, depths, tolerances)]
    numbers = np.array([row[:2] for row in rows], dtype=np.int64).reshape(-1, 2)
    seen = np.column_stack([here.centres[numbers[:, 0]], there.centres[numbers[:, 1]]])
    return StereoCandidates(
        numbers[:, 0],
        numbers[:, 1],
        _positions(seen, view.rig) @ view.camera.rotation.T + view.camera.position,
        np.array([row[2] for row in rows]),
    )


def _partners(
    here: DetectedKind,
    i: int,
    there: DetectedKind,
    rig: StereoRig,
    depths: tuple[float, float],
    tolerances: Tolerances,
) -> list[int]:
    """Return the primitives of the right image that may be one of the left image."""
    if not len(there.primitives):
        return []
    u, v = here.centres[i]
    disparities = (u - rig.left.cx) - (there.centres[:, 0] - rig.right.cx)
    ratios = there.sizes / here.sizes[i]
    near = np.flatnonzero(
        (np.abs(there.centres[:, 1] - v) <= ROWS_APART)
        & (disparities >= rig.left.fx * rig.baseline / depths[1])
        & (disparities <= rig.left.fx * rig.baseline / depths[0])
        & (ratios < SIZE_RATIO)
        & (ratios > 1.0 / SIZE_RATIO)
    )
    mine = here.primitives[i]
    return [int(j) for j in near if difference(there.primitives[j], mine, tolerances) <= SAME_SHAPE]


def _positions(seen: NDArray[np.float64], rig: StereoRig) -> NDArray[np.float64]:
    """Return points in the left optical frame, shape (n, 3), of u, v left and u, v right, shape (n, 4)."""
    left = rig.left
    z = left.fx * rig.baseline / ((seen[:, 0] - left.cx) - (seen[:, 2] - rig.right.cx))
    x = (seen[:, 0] - left.cx) / left.fx * z
    y = (0.5 * (seen[:, 1] + seen[:, 3]) - left.cy) / left.fy * z
    return np.column_stack([x, y, z])
