"""Small flat things on a floor, each an outline with a colour: chips, crumbs, hairs."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import numpy as np
from numpy.typing import ArrayLike, NDArray
from scipy.spatial import cKDTree


@dataclass(frozen=True)
class FloorMarks:
    """Polygons on the floor, in the map frame.

    Attributes:
        centres: shape (n, 2), reference points [m].
        outlines: shape (n, v, 2), corners relative to the reference points [m].
        colours: shape (n, 3), reflectance in blue, green and red, 0 to 1.
        opacities: shape (n,), fraction of the ground's light that a mark hides, 0 to 1.
    """

    centres: NDArray[np.float64]
    outlines: NDArray[np.float64]
    colours: NDArray[np.float64]
    opacities: NDArray[np.float64]

    def __len__(self) -> int:
        """Return the number of marks."""
        return len(self.centres)

    @cached_property
    def _tree(self) -> cKDTree:
        return cKDTree(self.centres)

    @cached_property
    def _reach(self) -> float:
        """Distance of the farthest corner from its reference point [m]."""
        return float(np.hypot(self.outlines[..., 0], self.outlines[..., 1]).max(initial=0.0))

    def near(self, point: ArrayLike, radius: float) -> NDArray[np.int64]:
        """Return which marks may reach into a disc.

        Args:
            point: array-like, shape (2,), centre of the disc [m].
            radius: radius of the disc [m].

        Returns:
            array, shape (k,), ascending indices of marks.
        """
        if len(self) == 0:
            return np.empty(0, dtype=np.int64)
        found = self._tree.query_ball_point(np.asarray(point, dtype=np.float64), radius + self._reach)
        return np.sort(np.asarray(found, dtype=np.int64))

    def select(self, indices: NDArray[np.int64] | NDArray[np.bool_]) -> FloorMarks:
        """Return the marks with these indices (or where the mask is true)."""
        return FloorMarks(
            self.centres[indices], self.outlines[indices], self.colours[indices], self.opacities[indices]
        )

    def corners(self) -> NDArray[np.float64]:
        """Return all corners in the map frame, shape (n, v, 2) [m]."""
        return np.asarray(self.centres[:, None] + self.outlines)
