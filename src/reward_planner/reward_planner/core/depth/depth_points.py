"""Points from a depth image."""

import math

import numpy as np
from numba import njit
from numpy.typing import NDArray

from reward_planner.core.reward_planner_error import RewardPlannerError
from shirube_core.geometry import PinholeCamera

NO_RETURN = np.float32(1000.0)
"""Depth of a ray that returned nothing: farther than any ``range_max`` [m]."""


def points_from_depth_image(
    depth: NDArray[np.float32], camera: PinholeCamera, shear: float = 0.0, nearest: float = 0.0
) -> NDArray[np.float32]:
    """Return the points of the pixels in the optical frame [m], shape (n, 3).

    REP 118: +inf is nothing within range, here a point farther than any range, whose ray clears space; -inf is too
    close to measure, an obstacle at the distance ``nearest`` [m], left out without one; NaN and depths of 0 and less
    are unknown and left out. The shear is P[0, 1] of the rectified image [px], see `rig_calibration`.

    Raises:
        RewardPlannerError: the sizes of image and camera differ, or the camera has distortion.
    """
    if depth.shape != (camera.height, camera.width):
        raise RewardPlannerError(
            f'the depth image has {depth.shape[::-1]} pixels, camera_info {camera.width} x {camera.height}; '
            'they must be equal'
        )
    if camera.has_distortion:
        raise RewardPlannerError('the camera of the depth image has distortion; give a rectified image')
    image = np.ascontiguousarray(depth, dtype=np.float32)
    return _points(image, (camera.fx, camera.fy, camera.cx, camera.cy, shear), nearest)


@njit(cache=True)
def _points(
    depth: NDArray[np.float32], intrinsics: tuple[float, float, float, float, float], nearest: float
) -> NDArray[np.float32]:
    fx, fy, cx, cy, shear = intrinsics
    points = np.empty((depth.size, 3), dtype=np.float32)
    count = 0
    for row in range(depth.shape[0]):
        for column in range(depth.shape[1]):
            z = depth[row, column]
            if z > 0.0 or (z == -np.inf and nearest > 0.0):
                y = (row - cy) / fy
                x = (column - cx - shear * y) / fx
                if z == np.inf:
                    z = NO_RETURN
                elif z == -np.inf:
                    z = nearest / math.sqrt(1.0 + x * x + y * y)
                points[count, 0] = x * z
                points[count, 1] = y * z
                points[count, 2] = z
                count += 1
    return points[:count]
