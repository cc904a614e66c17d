"""Geometry of a rectified stereo pair, horizontal or vertical."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import ArrayLike, NDArray

from reward_planner.core.depth.depth_error import DepthError

_TOLERANCE = 0.01  # [px]


@dataclass(frozen=True)
class StereoPair:
    """Geometry of the other camera relative to the left one, for whose image the depth is computed.

    Attributes:
        axis: 0 for a horizontal pair (rows are matched), 1 for a vertical pair (columns are matched).
        baseline: position of the other camera along that axis in the left camera's optical frame (x right, y down) [m];
            positive for a camera to the right or below.
        focal_length: focal length along the axis [px].
        offset: principal point of the left camera minus that of the other, along the axis [px].
    """

    axis: int
    baseline: float
    focal_length: float
    offset: float

    @property
    def sign(self) -> int:
        """Sign of the baseline."""
        return 1 if self.baseline > 0.0 else -1

    def mirror(self) -> StereoPair:
        """Return the pair with the other camera on the opposite side."""
        return replace(self, baseline=-self.baseline)

    @property
    def focal_baseline(self) -> float:
        """Depth at a disparity of one pixel, f b [px m]; always positive."""
        return self.focal_length * abs(self.baseline)


def pair_from_projections(P_left: ArrayLike, P_other: ArrayLike) -> StereoPair:
    """Return the stereo pair of two projection matrices of CameraInfo.

    The other camera is at -P[0, 3] / fx along x or at -P[1, 3] / fy along y.

    Args:
        P_left: projection matrix of the left camera, array-like, shape (3, 4).
        P_other: projection matrix of the right or top camera, array-like, shape (3, 4).

    Raises:
        DepthError: the cameras are not rectified to each other, or have no baseline.
    """
    left, other = _check_projection(P_left, 'left'), _check_projection(P_other, 'other')
    offset_along_axes = left[:2, 3] - other[:2, 3]
    axis = int(abs(offset_along_axes[1]) > abs(offset_along_axes[0]))
    if offset_along_axes[axis] == 0.0:
        raise DepthError(
            'P[0, 3] and P[1, 3] of both cameras are equal, there is no baseline; calibrate the pair'
        )
    if abs(offset_along_axes[1 - axis]) > _TOLERANCE * abs(offset_along_axes[axis]):
        raise DepthError('the cameras are neither a horizontal nor a vertical pair; rectify them as pairs')
    across = abs(left[1 - axis, 2] - other[1 - axis, 2])
    focal = np.abs(np.diag(left)[:2] - np.diag(other)[:2]).max()
    if max(across, focal) > _TOLERANCE:
        raise DepthError(
            f'focal lengths differ by {focal:.3g} px and principal points across the baseline by {across:.3g} px; '
            'rectify the cameras as pairs'
        )
    f = float(left[axis, axis])
    return StereoPair(axis, float(offset_along_axes[axis]) / f, f, float(left[axis, 2] - other[axis, 2]))


def _check_projection(P: ArrayLike, name: str) -> NDArray[np.float64]:
    matrix = np.asarray(P, dtype=np.float64)
    if matrix.shape != (3, 4) or not np.isfinite(matrix).all() or matrix[0, 0] <= 0.0 or matrix[1, 1] <= 0.0:
        raise DepthError(
            f'P of the {name} camera is not a projection matrix; give the 3 x 4 one of its calibration'
        )
    return matrix
