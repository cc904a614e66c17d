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
    """

    ids: NDArray[np.int64]
    rays: NDArray[np.float64]
    spreads: NDArray[np.float64]
    sigmas: NDArray[np.float64]
    motions: NDArray[np.float64]

    def __len__(self) -> int:
        """Return the number of sightings."""
        return len(self.ids)

    def subset(self, which: NDArray[np.bool_]) -> LampRays:
        """Return some of the sightings, shape (n,) of bool."""
        return LampRays(
            self.ids[which], self.rays[which], self.spreads[which], self.sigmas[which], self.motions[which]
        )

    def covariances(self, pixel_sigma: float) -> NDArray[np.float64]:
        """Return the covariances of the rays, shape (n, 2, 2).

        Args:
            pixel_sigma: error of the camera's calibration, beside that of the centres [px].
        """
        variances = self.sigmas**2 + pixel_sigma**2
        return variances[:, None, None] * (self.spreads @ self.spreads.transpose(0, 2, 1))


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
    )
