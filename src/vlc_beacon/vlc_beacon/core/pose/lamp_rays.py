"""Lamps in an image as rays of the camera with their uncertainty."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike, NDArray

from shirube_geometry import PinholeCamera


@dataclass(frozen=True)
class LampRays:
    """Where lamps are seen.

    Attributes:
        ids: shape (n,), of the lamps; one may occur more than once.
        rays: shape (n, 2), x and y of the undistorted rays in the optical frame, whose z is 1.
        spreads: shape (n, 2, 2), change of the rays with u and with v [1/px]; a lens makes that differ over the image.
        sigmas: shape (n,), standard deviation of the centres along each axis of the image [px].
        motions: shape (n, 3), x, y [m] and yaw [rad] of the base when the lamp was seen, in the base frame at the stamp
            of the pose: rows of a rolling shutter and earlier images are seen from elsewhere.
        views: shape (n,), number of the image in which each was seen, 0 for the image of the pose.
    """

    ids: NDArray[np.int64]
    rays: NDArray[np.float64]
    spreads: NDArray[np.float64]
    sigmas: NDArray[np.float64]
    motions: NDArray[np.float64]
    views: NDArray[np.int64]

    def __len__(self) -> int:
        """Return the number of sightings."""
        return len(self.ids)

    def subset(self, which: NDArray[np.bool_]) -> LampRays:
        """Return some of the sightings, shape (n,) of bool."""
        return LampRays(
            self.ids[which],
            self.rays[which],
            self.spreads[which],
            self.sigmas[which],
            self.motions[which],
            self.views[which],
        )

    @property
    def copied(self) -> NDArray[np.bool_]:
        """Shape (n,), sightings of a lamp that is seen more than once in an image."""
        keys = np.column_stack([self.ids, self.views])
        same = (keys[:, None] == keys[None]).all(axis=2)
        return np.asarray(same.sum(axis=1) > 1)

    def covariances(self, pixel_sigma: float) -> NDArray[np.float64]:
        """Return the covariances of the rays, shape (n, 2, 2).

        Args:
            pixel_sigma: error of the camera's calibration, beside that of the centres [px].
        """
        variances = self.sigmas**2 + pixel_sigma**2
        return variances[:, None, None] * (self.spreads @ self.spreads.transpose(0, 2, 1))


def motions_of_rows(rows: ArrayLike, row_time: float, velocity: ArrayLike) -> NDArray[np.float64]:
    """Return how the base moved until rows of a rolling shutter were exposed, shape (n, 3), as in `LampRays`.

    Args:
        rows: shape (n,), of the lamps' centres; row 0 was exposed at the stamp.
        row_time: between the beginnings of two rows [s].
        velocity: shape (3,), of the base along its x and y [m/s] and its turning rate [rad/s].
    """
    delays = np.asarray(rows, dtype=np.float64)[:, None] * row_time
    speed = np.asarray(velocity, dtype=np.float64)
    half = 0.5 * speed[2] * delays[:, 0]
    # The chord of an arc points into the middle of the turn.
    cos, sin = np.cos(half), np.sin(half)
    chord = delays * np.sinc(half / np.pi)[:, None] * speed[:2]
    return np.column_stack(
        [cos * chord[:, 0] - sin * chord[:, 1], sin * chord[:, 0] + cos * chord[:, 1], 2.0 * half]
    )


def lamp_rays(
    camera: PinholeCamera,
    ids: ArrayLike,
    pixels: ArrayLike,
    sigmas: ArrayLike,
    motions: ArrayLike | None = None,
) -> LampRays:
    """Return the rays of lamps in an image.

    Args:
        camera: intrinsics.
        ids: shape (n,).
        pixels: shape (n, 2), centres of the lamps [px].
        sigmas: shape (n,), standard deviation of the centres along each axis [px].
        motions: shape (n, 3) as in `LampRays`, None where the robot stood still.
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
