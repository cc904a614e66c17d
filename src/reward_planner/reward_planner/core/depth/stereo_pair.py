"""Two cameras that are rectified to each other, side by side or one above the other."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import ArrayLike, NDArray

from reward_planner.core.depth.depth_error import DepthError

_SAME_WITHIN = 0.01  # [px]


@dataclass(frozen=True)
class StereoPair:
    """How the other camera lies to the left one, whose image the depth is for.

    Attributes:
        axis: 0 if the other camera lies along x (rows are matched), 1 if along y (columns are matched).
        baseline: where it lies along that axis, in the left camera's optical frame [m]; x goes right and y down, so
            that a camera to the right or below has a positive one.
        focal_length: along the axis [px].
        offset: principal point of the left camera less that of the other, along the axis [px].
    """

    axis: int
    baseline: float
    focal_length: float
    offset: float

    @property
    def sign(self) -> int:
        """The sign of the baseline."""
        return 1 if self.baseline > 0.0 else -1

    def mirrored(self) -> StereoPair:
        """Return the pair with the other camera on the opposite side."""
        return replace(self, baseline=-self.baseline)

    @property
    def focal_baseline(self) -> float:
        """The depth of what has a disparity of one pixel, f b [px m]; always positive."""
        return self.focal_length * abs(self.baseline)


def pair_from_projections(P_left: ArrayLike, P_other: ArrayLike) -> StereoPair:
    """Return the pair of two projection matrices, as CameraInfo gives them.

    The other camera lies at -P[0, 3] / fx along x or at -P[1, 3] / fy along y.

    Args:
        P_left: array-like, shape (3, 4), of the left camera.
        P_other: array-like, shape (3, 4), of the right or of the top camera.

    Raises:
        DepthError: matrices that are not those of rectified cameras, or no baseline.
    """
    left, other = _checked(P_left, 'left'), _checked(P_other, 'other')
    shift = left[:2, 3] - other[:2, 3]
    axis = int(abs(shift[1]) > abs(shift[0]))
    if shift[axis] == 0.0:
        raise DepthError(
            'P[0, 3] and P[1, 3] of both cameras are equal, there is no baseline; calibrate the pair'
        )
    if abs(shift[1 - axis]) > _SAME_WITHIN * abs(shift[axis]):
        raise DepthError(
            'the cameras lie neither side by side nor one above the other; rectify them as pairs'
        )
    across = abs(left[1 - axis, 2] - other[1 - axis, 2])
    focal = np.abs(np.diag(left)[:2] - np.diag(other)[:2]).max()
    if max(across, focal) > _SAME_WITHIN:
        raise DepthError(
            f'focal lengths differ by {focal:.3g} px and principal points across the baseline by {across:.3g} px; '
            'rectify the cameras as pairs'
        )
    f = float(left[axis, axis])
    return StereoPair(axis, float(shift[axis]) / f, f, float(left[axis, 2] - other[axis, 2]))


def _checked(P: ArrayLike, name: str) -> NDArray[np.float64]:
    matrix = np.asarray(P, dtype=np.float64)
    if matrix.shape != (3, 4) or not np.isfinite(matrix).all() or matrix[0, 0] <= 0.0 or matrix[1, 1] <= 0.0:
        raise DepthError(
            f'P of the {name} camera is no projection matrix; give the 3 x 4 one of its calibration'
        )
    return matrix
