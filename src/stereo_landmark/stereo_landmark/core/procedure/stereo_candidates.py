"""Which detected primitives may be a taught one, and where they are in space."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from stereo_landmark.core.place.stereo_rig import StereoRig
from stereo_landmark.core.procedure.detected_scene import DetectedKind
from stereo_landmark.core.procedure.primitive import Primitive, Tolerances, difference, kind_of, size_of
from stereo_landmark.core.procedure.stereo_view import StereoView


@dataclass(frozen=True)
class StereoCandidates:
    """Detected primitives that may be one taught primitive.

    Attributes:
        left: numbers among those of its kind in the left image, shape (n,).
        right: the same in the right image, shape (n,).
        centres: u, v left and u right, shape (n, 3) [px].
        positions: of their centres in the level base frame, shape (n, 3) [m].
    """

    left: NDArray[np.int64]
    right: NDArray[np.int64]
    centres: NDArray[np.float64]
    positions: NDArray[np.float64]

    def __len__(self) -> int:
        return len(self.left)


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
    kind = kind_of(taught)
    here, there = view.both(kind)
    partners = view.partners[kind]
    left = np.array([i for i in _alike(taught, here, tolerances) if i in partners], dtype=np.int64)
    right = np.array([partners[i] for i in left.tolist()], dtype=np.int64)
    seen = np.column_stack([here.centres[left], there.centres[right]])
    points = _points(seen, view.rig)
    kept = (points[:, 2] >= depths[0]) & (points[:, 2] <= depths[1])
    positions = points[kept] @ view.camera.rotation.T + view.camera.position
    return StereoCandidates(left[kept], right[kept], seen[kept, :3], positions)


def _alike(taught: Primitive, among: DetectedKind, tolerances: Tolerances) -> list[int]:
    """Return the numbers of the primitives that are within the tolerances."""
    if not among.primitives:
        return []
    largest = 1.0 + max(
        tolerances.ellipse.axes, tolerances.quadrilateral.size, tolerances.parallel_lines.width
    )
    ratios = among.sizes / size_of(taught)
    near = np.flatnonzero((ratios < largest) & (ratios > 1.0 / largest)).tolist()
    return [i for i in near if difference(among.primitives[i], taught, tolerances) <= 1.0]


def _points(seen: NDArray[np.float64], rig: StereoRig) -> NDArray[np.float64]:
    """Return points in the left optical frame, shape (n, 3), of u, v left and u, v right, shape (n, 4)."""
    left = rig.left
    z = left.fx * rig.baseline / ((seen[:, 0] - left.cx) - (seen[:, 2] - rig.right.cx))
    x = (seen[:, 0] - left.cx) / left.fx * z
    y = (0.5 * (seen[:, 1] + seen[:, 3]) - left.cy) / left.fy * z
    return np.column_stack([x, y, z])
