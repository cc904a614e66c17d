"""Points that share their noise: the corners of a quadrilateral, each two of which lie on one side."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from stereo_landmark.core.place.stereo_points import SpatialPoints, StereoPoints
from stereo_landmark.core.place.stereo_rig import MEASURED

VARIANCE_MIN = 1e-18
"""Added to the variances of taught points, so that exact ones have an inverse, too [m²]."""


class NoiseGroups(NamedTuple):
    """Groups of equal size.

    Attributes:
        members: shape (g, m), numbers of points.
        seen: shape (g, m, 4, m, 4), covariance of what is seen of them [px²].
        taught: shape (g, m, 3, m, 3), covariance of where they were taught [m²].
    """

    members: NDArray[np.int64]
    seen: NDArray[np.float64]
    taught: NDArray[np.float64]

    def spreads(self, by_point: NDArray[np.float64]) -> NDArray[np.float64]:
        """Return the covariances of what is seen less what is expected, shape (g, 4 m, 4 m) [px²].

        Args:
            by_point: derivatives of what is seen of all points by where they are, shape (n, 4, 3) [px/m].
        """
        by = by_point[self.members]
        expected = np.einsum('gaik,gakbl,gbjl->gaibj', by, self.taught, by, optimize=True)
        groups, size = self.members.shape
        return np.asarray((self.seen + expected).reshape(groups, MEASURED * size, MEASURED * size))


def noise_groups(
    seen: StereoPoints, taught: SpatialPoints, by_point: NDArray[np.float64], pixel_sigma: float
) -> list[NoiseGroups]:
    """Return the groups of points that share noise; a point that shares none is one alone.

    Of taught points only their own covariances are known. They were measured as they are now, so their errors are as
    correlated as those of the present ones, triangulated.

    Args:
        seen: n points.
        taught: the same points in the same order.
        by_point: shape (n, 4, 3), see `NoiseGroups.spreads`.
        pixel_sigma: error of the calibration along each axis of each image, each point's own [px].
    """
    if seen.between is None:
        labels = np.arange(len(seen))
    else:
        shares = seen.between.any(axis=(1, 3)) | np.eye(len(seen), dtype=np.bool_)
        labels = np.argmax(shares, axis=1)
    firsts, sizes = np.unique(labels, return_counts=True)
    found = []
    for size in np.unique(sizes).tolist():
        members = np.array([np.flatnonzero(labels == first) for first in firsts[sizes == size]])
        found.append(_groups(members, seen, taught, by_point, pixel_sigma))
    return found


def _groups(
    members: NDArray[np.int64],
    seen: StereoPoints,
    taught: SpatialPoints,
    by_point: NDArray[np.float64],
    pixel_sigma: float,
) -> NoiseGroups:
    count = members.shape[1]
    noise = np.zeros((*members.shape, MEASURED, count, MEASURED))
    places = np.zeros((*members.shape, 3, count, 3))
    own = np.arange(count)
    noise[:, own, :, own] = seen.covariances[members].transpose(1, 0, 2, 3)
    if count > 1 and seen.between is not None:
        noise += seen.between[members[:, :, None], :, members[:, None, :]].transpose(0, 1, 3, 2, 4)
        places += _taught_alike(noise, taught.covariances[members], by_point[members])
    places[:, own, :, own] = taught.covariances[members].transpose(1, 0, 2, 3)
    noise[:, own, :, own] += pixel_sigma**2 * np.eye(MEASURED)
    return NoiseGroups(members, noise, places)


def _taught_alike(
    noise: NDArray[np.float64], taught: NDArray[np.float64], by_point: NDArray[np.float64]
) -> NDArray[np.float64]:
    """Return covariances of taught points as correlated as the triangulated present ones, shape (g, m, 3, m, 3).

    Args:
        noise: shape (g, m, 4, m, 4), of the present ones [px²].
        taught: shape (g, m, 3, 3), of each taught one [m²].
        by_point: shape (g, m, 4, 3) [px/m].
    """
    own = np.einsum('gaiaj->gaij', noise)
    weighed = np.linalg.solve(own, by_point).swapaxes(2, 3)
    now = np.linalg.inv(weighed @ by_point)
    root, root_now = (np.linalg.cholesky(part + VARIANCE_MIN * np.eye(3)) for part in (taught, now))
    # What triangulates a present point, made as uncertain as the taught one.
    maps = root @ np.linalg.solve(root_now, now @ weighed)
    return np.asarray(np.einsum('gaki,gaibj,gblj->gakbl', maps, noise, maps, optimize=True))
