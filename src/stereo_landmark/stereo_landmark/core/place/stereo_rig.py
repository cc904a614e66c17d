"""A rectified stereo camera on a robot."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from shirube_core.geometry import CameraMount, PinholeCamera
from stereo_landmark.core.stereo_landmark_error import StereoLandmarkError

MEASUREMENT_SIZE = 4
"""Number of measured coordinates of a point: u, v in the left and u, v in the right image."""


@dataclass(frozen=True)
class StereoRig:
    """Rectified stereo cameras: rows are the same in both, and the right camera is at +x of the left one.

    Attributes:
        left: intrinsics of the left camera after rectification, without distortion.
        right: intrinsics of the right camera after rectification.
        baseline: distance between the cameras [m].
        mount: extrinsics of the left camera's optical frame on the robot.

    Raises:
        StereoLandmarkError: the baseline is not positive, or the cameras do not belong together.
    """

    left: PinholeCamera
    right: PinholeCamera
    baseline: float
    mount: CameraMount

    def __post_init__(self) -> None:
        if not (math.isfinite(self.baseline) and self.baseline > 0.0):
            raise StereoLandmarkError(
                f'baseline is {self.baseline:g} m, it must be positive; '
                "the right camera's projection_matrix holds -fx * baseline at [0, 3]: are left and right swapped?"
            )
        for name in ('fx', 'fy', 'cy', 'width', 'height'):
            left_value, right_value = getattr(self.left, name), getattr(self.right, name)
            if not math.isclose(left_value, right_value, rel_tol=1e-6):
                raise StereoLandmarkError(
                    f'{name} is {left_value:g} in the left and {right_value:g} in the right camera; '
                    'rectified cameras share it: calibrate them as a pair'
                )

    def project(self, points: NDArray[np.float64]) -> NDArray[np.float64]:
        """Project points, shape (n, 4): u, v left and u, v right [px].

        Args:
            points: points in the left optical frame, in front of the cameras, shape (n, 3) [m].
        """
        x, y, z = points.T
        v = self.left.fy * y / z + self.left.cy
        u_left = self.left.fx * x / z + self.left.cx
        u_right = self.right.fx * (x - self.baseline) / z + self.right.cx
        return np.column_stack([u_left, v, u_right, v])

    def jacobians(self, points: NDArray[np.float64]) -> NDArray[np.float64]:
        """Return the derivatives of `project` by the points, shape (n, 4, 3) [px/m]."""
        x, y, z = points.T
        zero = np.zeros_like(z)
        along_v = [zero, self.left.fy / z, -self.left.fy * y / z**2]
        along_left = [self.left.fx / z, zero, -self.left.fx * x / z**2]
        along_right = [self.right.fx / z, zero, -self.right.fx * (x - self.baseline) / z**2]
        rows = np.array([along_left, along_v, along_right, along_v])
        return np.ascontiguousarray(rows.transpose(2, 0, 1))
