"""Stereo point measurements and their triangulation (paper 3.4)."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from stereo_landmark.core.place.stereo_rig import MEASUREMENT_SIZE, StereoRig

DISPARITY_MIN = 0.5
"""Minimum disparity; a point below it is too far away, or a wrong match [px]."""
ROW_GATE_SIGMAS = 5.0
ITERATIONS = 3


@dataclass(frozen=True)
class StereoPoints:
    """Named points in a rectified stereo pair.

    Attributes:
        names: n unique names.
        pixels: u, v in the left and u, v in the right image, shape (n, 4) [px].
        covariances: covariances of the pixels, shape (n, 4, 4) [px²].
    """

    names: tuple[str, ...]
    pixels: NDArray[np.float64]
    covariances: NDArray[np.float64]

    def __len__(self) -> int:
        return len(self.names)

    def subset(self, kept: NDArray[np.bool_]) -> StereoPoints:
        """Return the points selected by a mask, shape (n,)."""
        names = tuple(name for name, is_kept in zip(self.names, kept, strict=True) if is_kept)
        return StereoPoints(names, self.pixels[kept], self.covariances[kept])


@dataclass(frozen=True)
class SpatialPoints:
    """Named 3D points.

    Attributes:
        names: n unique names.
        positions: coordinates, shape (n, 3) [m].
        covariances: covariances of the coordinates, shape (n, 3, 3) [m²].
    """

    names: tuple[str, ...]
    positions: NDArray[np.float64]
    covariances: NDArray[np.float64]

    def __len__(self) -> int:
        return len(self.names)

    def select(self, names: tuple[str, ...]) -> SpatialPoints:
        """Return the points with these names, in their order; all must exist."""
        index = [self.names.index(name) for name in names]
        return SpatialPoints(names, self.positions[index], self.covariances[index])

    def transform(self, rotation: NDArray[np.float64], shift: NDArray[np.float64]) -> SpatialPoints:
        """Transform the points into another frame: rotation, shape (3, 3), then translation, shape (3,) [m]."""
        positions = self.positions @ rotation.T + shift
        return SpatialPoints(self.names, positions, rotation @ self.covariances @ rotation.T)


def concatenate(groups: Sequence[StereoPoints]) -> StereoPoints:
    """Concatenate sets of points."""
    return StereoPoints(
        tuple(name for group in groups for name in group.names),
        np.concatenate([np.empty((0, MEASUREMENT_SIZE)), *(group.pixels for group in groups)]),
        np.concatenate(
            [np.empty((0, MEASUREMENT_SIZE, MEASUREMENT_SIZE)), *(group.covariances for group in groups)]
        ),
    )


def is_measurable(points: StereoPoints, rig: StereoRig) -> NDArray[np.bool_]:
    """Return the mask of points with enough disparity to be triangulated, shape (n,)."""
    return _disparities(points.pixels, rig) >= DISPARITY_MIN


def is_in_same_row(points: StereoPoints, pixel_sigma: float) -> NDArray[np.bool_]:
    """Return the mask of points that satisfy the epipolar constraint (same row in both images), shape (n,).

    Args:
        points: n points.
        pixel_sigma: calibration error along each axis of each image [px].
    """
    variances = points.covariances[:, 1, 1] + points.covariances[:, 3, 3] - 2.0 * points.covariances[:, 1, 3]
    row_difference = np.abs(points.pixels[:, 1] - points.pixels[:, 3])
    return np.asarray(row_difference <= ROW_GATE_SIGMAS * np.sqrt(variances + 2.0 * pixel_sigma**2))


def add_calibration_noise(points: StereoPoints, pixel_sigma: float) -> StereoPoints:
    """Return points with the calibration error [px] added to their covariances.

    Without it the depths of near points would be too certain, and the fit would rotate about the target.
    """
    return StereoPoints(
        points.names, points.pixels, points.covariances + pixel_sigma**2 * np.eye(MEASUREMENT_SIZE)
    )


def triangulate(points: StereoPoints, rig: StereoRig) -> SpatialPoints:
    """Triangulate points into the left optical frame, with covariances propagated from the pixel noise.

    Args:
        points: points with a measurable disparity.
        rig: stereo cameras.
    """
    pixels, left = points.pixels, rig.left
    z = left.fx * rig.baseline / _disparities(pixels, rig)
    x = (pixels[:, 0] - left.cx) / left.fx * z
    y = (0.5 * (pixels[:, 1] + pixels[:, 3]) - left.cy) / left.fy * z
    positions = np.column_stack([x, y, z])
    weights = np.linalg.inv(points.covariances)
    for _ in range(ITERATIONS):
        jacobians = rig.jacobians(positions)
        information = jacobians.transpose(0, 2, 1) @ weights @ jacobians
        gradients = jacobians.transpose(0, 2, 1) @ weights @ (pixels - rig.project(positions))[:, :, None]
        positions = positions + np.linalg.solve(information, gradients)[:, :, 0]
    return SpatialPoints(points.names, positions, np.asarray(np.linalg.inv(information)))


def _disparities(pixels: NDArray[np.float64], rig: StereoRig) -> NDArray[np.float64]:
    """Return the disparities, shape (n,), 0 at infinity [px]."""
    return np.asarray((pixels[:, 0] - rig.left.cx) - (pixels[:, 2] - rig.right.cx))
