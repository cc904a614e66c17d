"""One measurement of a range sensor as rays in the base frame."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from reward_planner.core.reward_planner_error import RewardPlannerError
from shirube_core.geometry import PinholeCamera

POINTS_MAX = 20_000
"""Denser measurements are thinned: enough for a leg at 4 m, and single wrong points stay rare."""


@dataclass(frozen=True)
class RangeFrame:
    """Rays from the sensor to what they hit, or as far as they hit nothing.

    Attributes:
        origin: position of the sensor in the base frame, shape (3,) [m].
        ends: ends of the rays in the base frame, shape (n, 3) [m], finite.
        is_hit: whether a ray ends on a surface, shape (n,).
    """

    origin: NDArray[np.float64]
    ends: NDArray[np.float64]
    is_hit: NDArray[np.bool_]


def range_frame(
    points: NDArray[np.float32],
    is_hit: NDArray[np.bool_],
    R_base_sensor: NDArray[np.float64],
    origin: NDArray[np.float64],
) -> RangeFrame:
    """Return the frame of ray ends in the sensor frame, shape (n, 3) [m]; rays that are not finite are unknown."""
    stride = thinning_stride(len(points))
    thin, hit = points[::stride], is_hit[::stride]
    finite = np.isfinite(thin).all(axis=1)
    ends = thin[finite].astype(np.float64) @ R_base_sensor.T + origin
    return RangeFrame(origin, ends, hit[finite])


def thinning_stride(count: int) -> int:
    """Return an odd stride, which visits all columns of an image in turn."""
    return -(-count // POINTS_MAX) | 1 if count > POINTS_MAX else 1


def depth_rays(
    depth: NDArray[np.float32], camera: PinholeCamera, limits: tuple[float, float]
) -> tuple[NDArray[np.float32], NDArray[np.bool_]]:
    """Return ray ends in the optical frame, shape (n, 3) [m], and which of them hit, shape (n,).

    REP 118: +inf is nothing within range, free up to the greater limit; -inf is too close, an obstacle at the
    smaller one; NaN is unknown, as is 0.

    Raises:
        RewardPlannerError: the sizes of image and camera differ, or the camera has distortion.
    """
    if depth.shape != (camera.height, camera.width) or camera.has_distortion:
        raise RewardPlannerError(
            f'the depth image has {depth.shape[1]} x {depth.shape[0]} pixels, camera_info {camera.width} x '
            f'{camera.height}; give a rectified image with its calibration'
        )
    stride = thinning_stride(depth.size)
    z = depth.reshape(-1)[::stride]
    row, column = np.divmod(np.arange(depth.size, dtype=np.int64)[::stride], camera.width)
    length = np.select([z == np.inf, z == -np.inf, z > 0.0], [limits[1], limits[0], z], np.nan)
    x, y = (column - camera.cx) / camera.fx * length, (row - camera.cy) / camera.fy * length
    return np.column_stack([x, y, length]).astype(np.float32), z != np.inf
