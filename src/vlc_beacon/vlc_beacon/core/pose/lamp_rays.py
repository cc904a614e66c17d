"""Known lamps, and their observations as camera rays with uncertainty."""

from __future__ import annotations

from dataclasses import dataclass, fields

import numpy as np
from numpy.typing import ArrayLike, NDArray

from shirube_core.geometry import PinholeCamera


@dataclass(frozen=True)
class Beacon:
    """A lamp of the beacons file.

    Attributes:
        id: transmitted ID.
        xyz: position of its centre in the map frame [m].
        radius: radius of its bright disc [m].
        frequency: constant tone sent instead of an ID [Hz], None for a lamp that sends its ID.
    """

    id: int
    xyz: tuple[float, float, float]
    radius: float
    frequency: float | None = None


@dataclass(frozen=True)
class LampRays:
    """Observations of lamps.

    Attributes:
        ids: lamp IDs, shape (n,); an ID may occur more than once.
        rays: x and y of the undistorted rays with z = 1 in the optical frame, shape (n, 2).
        pixel_jacobians: Jacobians of the rays with respect to (u, v), shape (n, 2, 2) [1/px], with lens distortion.
        sigmas: standard deviation of the centres along each image axis, shape (n,) [px].
        motions: pose (x, y [m], yaw [rad]) of the base at each observation, in the base frame at the stamp of the
            pose, shape (n, 3); not zero for rolling shutter rows and earlier images.
        views: index of the image of each observation, shape (n,), 0 for the image of the pose.
    """

    ids: NDArray[np.int64]
    rays: NDArray[np.float64]
    pixel_jacobians: NDArray[np.float64]
    sigmas: NDArray[np.float64]
    motions: NDArray[np.float64]
    views: NDArray[np.int64]

    def __len__(self) -> int:
        return len(self.ids)

    def subset(self, mask: NDArray[np.bool_]) -> LampRays:
        """Return the observations selected by a mask, shape (n,)."""
        return LampRays(*(getattr(self, each.name)[mask] for each in fields(self)))

    @property
    def is_valid(self) -> NDArray[np.bool_]:
        """Mask of observations within the valid range of the lens model, shape (n,)."""
        return np.asarray(np.isfinite(self.pixel_jacobians).all(axis=(1, 2)))

    @property
    def is_duplicate(self) -> NDArray[np.bool_]:
        """Mask of observations whose ID occurs more than once in an image, shape (n,)."""
        keys = np.column_stack([self.ids, self.views])
        same = (keys[:, None] == keys[None]).all(axis=2)
        return np.asarray(same.sum(axis=1) > 1)

    def covariances(self, pixel_sigma: float) -> NDArray[np.float64]:
        """Return the covariances of the rays, shape (n, 2, 2), with that of the calibration [px]."""
        variances = self.sigmas**2 + pixel_sigma**2
        return variances[:, None, None] * (self.pixel_jacobians @ self.pixel_jacobians.transpose(0, 2, 1))


def row_motions(rows: ArrayLike, row_time: float, velocity: ArrayLike) -> NDArray[np.float64]:
    """Return the motion of the base, as in `LampRays`, until rows of a rolling shutter were exposed.

    Args:
        rows: image rows of the lamp centres, shape (n,); row 0 was exposed at the stamp.
        row_time: line time between the starts of two rows [s].
        velocity: velocity of the base along its x and y [m/s] and yaw rate [rad/s], shape (3,).
    """
    delays = np.asarray(rows, dtype=np.float64)[:, None] * row_time
    speed = np.asarray(velocity, dtype=np.float64)
    half = 0.5 * speed[2] * delays[:, 0]
    # The chord of an arc points in the mean direction of the turn.
    cos, sin = np.cos(half), np.sin(half)
    chord = delays * np.sinc(half / np.pi)[:, None] * speed[:2]
    return np.column_stack([cos * chord[:, 0] - sin * chord[:, 1], sin * chord[:, 0] + cos * chord[:, 1], 2.0 * half])


def lamp_rays(
    camera: PinholeCamera, ids: ArrayLike, pixels: ArrayLike, sigmas: ArrayLike, motions: ArrayLike | None = None
) -> LampRays:
    """Return the rays of lamps in an image.

    Args:
        camera: camera intrinsics.
        ids: lamp IDs, shape (n,).
        pixels: centres of the lamps, shape (n, 2) [px].
        sigmas: standard deviation of the centres along each axis, shape (n,) [px].
        motions: motions of the base, shape (n, 3), as in `LampRays`, None if the robot is stationary.
    """
    centres = np.asarray(pixels, dtype=np.float64).reshape(-1, 2)
    count = len(centres)
    shifts = np.repeat(0.5 * np.array([[0.0, 0.0], [1.0, 0.0], [0.0, 1.0]]), count, axis=0)
    shifted = np.tile(centres, (3, 1)) + shifts
    rays = camera.rays_from_pixels(shifted)[:, :2].reshape(3, count, 2)
    return LampRays(
        np.asarray(ids, dtype=np.int64).reshape(-1),
        rays[0],
        np.stack([rays[1] - rays[0], rays[2] - rays[0]], axis=2) * 2.0,
        np.asarray(sigmas, dtype=np.float64).reshape(-1),
        np.zeros((count, 3)) if motions is None else np.asarray(motions, dtype=np.float64).reshape(-1, 3),
        np.zeros(count, dtype=np.int64),
    )
