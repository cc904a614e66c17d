"""Points that both cameras see, and where they are in space (eq. of the paper's stereo measurement, 3.4)."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from stereo_landmark.core.place.stereo_rig import MEASURED, StereoRig

DISPARITY_MIN = 0.5
"""A point with less [px] is too far away to be measured, or a wrong match."""
ROW_SIGMAS = 5.0
STEPS = 3


@dataclass(frozen=True)
class StereoPoints:
    """Named points in a rectified pair of images.

    Attributes:
        names: n names, each once.
        pixels: shape (n, 4), u, v in the left and u, v in the right image [px].
        covariances: shape (n, 4, 4) [px²].
    """

    names: tuple[str, ...]
    pixels: NDArray[np.float64]
    covariances: NDArray[np.float64]

    def __len__(self) -> int:
        return len(self.names)

    def subset(self, kept: NDArray[np.bool_]) -> StereoPoints:
        """Return the points of a mask, shape (n,)."""
        names = tuple(name for name, is_kept in zip(self.names, kept, strict=True) if is_kept)
        return StereoPoints(names, self.pixels[kept], self.covariances[kept])


@dataclass(frozen=True)
class SpatialPoints:
    """Named points in space.

    Attributes:
        names: n names, each once.
        positions: shape (n, 3) [m].
        covariances: shape (n, 3, 3) [m²].
    """

    names: tuple[str, ...]
    positions: NDArray[np.float64]
    covariances: NDArray[np.float64]

    def __len__(self) -> int:
        return len(self.names)

    def selected(self, names: tuple[str, ...]) -> SpatialPoints:
        """Return the points with these names, in their order; all must be there."""
        index = [self.names.index(name) for name in names]
        return SpatialPoints(names, self.positions[index], self.covariances[index])

    def moved(self, rotation: NDArray[np.float64], shift: NDArray[np.float64]) -> SpatialPoints:
        """Return the points in another frame: rotation, shape (3, 3), then shift, shape (3,) [m]."""
        positions = self.positions @ rotation.T + shift
        return SpatialPoints(self.names, positions, rotation @ self.covariances @ rotation.T)


def joined(parts: Sequence[StereoPoints]) -> StereoPoints:
    """Return all points of some."""
    return StereoPoints(
        tuple(name for part in parts for name in part.names),
        np.concatenate([np.empty((0, MEASURED)), *(part.pixels for part in parts)]),
        np.concatenate([np.empty((0, MEASURED, MEASURED)), *(part.covariances for part in parts)]),
    )


def measurable(points: StereoPoints, rig: StereoRig) -> NDArray[np.bool_]:
    """Return which points are near enough to be measured, shape (n,)."""
    return _disparities(points.pixels, rig) >= DISPARITY_MIN


def rows_agree(points: StereoPoints, pixel_sigma: float) -> NDArray[np.bool_]:
    """Return which points both images show in the same row, shape (n,): others are not one thing in space.

    Args:
        points: n points.
        pixel_sigma: error of the calibration along each axis of each image [px].
    """
    variances = points.covariances[:, 1, 1] + points.covariances[:, 3, 3] - 2.0 * points.covariances[:, 1, 3]
    apart = np.abs(points.pixels[:, 1] - points.pixels[:, 3])
    return np.asarray(apart <= ROW_SIGMAS * np.sqrt(variances + 2.0 * pixel_sigma**2))


def with_calibration_error(points: StereoPoints, pixel_sigma: float) -> StereoPoints:
    """Return points as well known as they are with cameras whose calibration is off by so much [px].

    Without it, nearby depths look better known than any calibration allows, and a fit turns about the target.
    """
    return StereoPoints(points.names, points.pixels, points.covariances + pixel_sigma**2 * np.eye(MEASURED))


def triangulate(points: StereoPoints, rig: StereoRig) -> SpatialPoints:
    """Return the points in the left optical frame with the covariance that their noise leaves.

    Args:
        points: measurable ones.
        rig: the cameras.
    """
    pixels, left = points.pixels, rig.left
    z = left.fx * rig.baseline / _disparities(pixels, rig)
    x = (pixels[:, 0] - left.cx) / left.fx * z
    y = (0.5 * (pixels[:, 1] + pixels[:, 3]) - left.cy) / left.fy * z
    positions = np.column_stack([x, y, z])
    weights = np.linalg.inv(points.covariances)
    for _ in range(STEPS):
        jacobians = rig.jacobians(positions)
        information = jacobians.transpose(0, 2, 1) @ weights @ jacobians
        gradients = jacobians.transpose(0, 2, 1) @ weights @ (pixels - rig.projections(positions))[:, :, None]
        positions = positions + np.linalg.solve(information, gradients)[:, :, 0]
    return SpatialPoints(points.names, positions, np.asarray(np.linalg.inv(information)))


def _disparities(pixels: NDArray[np.float64], rig: StereoRig) -> NDArray[np.float64]:
    """Return how far apart both images see the points, shape (n,), 0 for infinitely far [px]."""
    return np.asarray((pixels[:, 0] - rig.left.cx) - (pixels[:, 2] - rig.right.cx))
