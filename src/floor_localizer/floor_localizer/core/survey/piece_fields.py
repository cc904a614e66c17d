"""The dots of all submaps, in an array store; bounding boxes and the last used matchers are in memory."""

from __future__ import annotations

from collections import OrderedDict

import numpy as np
from numpy.typing import NDArray

from floor_localizer.core.survey.dot_matching import DotField
from floor_localizer.core.survey.shelf import Shelf
from shirube_geometry import PlanarPose

_MOST_KEPT = 64


class PieceFields:
    """Dot matchers of all submaps, each in its own frame, with an LRU cache."""

    def __init__(self, shelf: Shelf) -> None:
        """Begin without a submap."""
        self._shelf = shelf
        self._kept: OrderedDict[int, DotField] = OrderedDict()
        # Lower and upper corner of each submap, with spare capacity.
        self._corners = np.empty((_MOST_KEPT, 2, 2))
        self._count = 0

    def append(self, dots: NDArray[np.float64]) -> None:
        """Add the dots of the next submap, shape (n, 2) [m], n >= 1."""
        if self._count == len(self._corners):
            self._corners = np.concatenate([self._corners, np.empty_like(self._corners)])
        self._shelf.put('piece', self._count, dots)
        self._corners[self._count] = dots.min(axis=0), dots.max(axis=0)
        self._count += 1

    def dots(self, index: int) -> NDArray[np.float64]:
        """Return the dots of a submap, shape (n, 2) [m]."""
        (dots,) = self._shelf.get('piece', index)
        return dots

    def __getitem__(self, index: int) -> DotField:
        """Return the matcher of a submap."""
        if index not in self._kept:
            self._kept[index] = DotField(self.dots(index))
            if len(self._kept) > _MOST_KEPT:
                self._kept.popitem(last=False)
        self._kept.move_to_end(index)
        return self._kept[index]

    def may_overlap(self, index: int, other: int, pose: PlanarPose, radius: float) -> bool:
        """Return whether the bounding boxes of two submaps may overlap.

        Args:
            index: index of the submap.
            other: index of the other submap.
            pose: pose of the submap in the frame of the other one.
            radius: uncertainty of its position [m].
        """
        placed, (lower, upper) = pose.transform(self[index].points), self._corners[other]
        return bool(
            (placed.min(axis=0) - radius < upper).all() and (placed.max(axis=0) + radius > lower).all()
        )

    def overlap_candidates(
        self, index: int, turns: NDArray[np.complex128], shifts: NDArray[np.complex128], radius: float
    ) -> NDArray[np.int64]:
        """Return a superset of the submaps for which `may_overlap` is true, by bounding circles.

        Args:
            index: index of a submap.
            turns: complex rotations of the submaps, of magnitude 1, shape (n,).
            shifts: complex translations of the submaps, shape (n,) [m].
            radius: uncertainty of the submap's position [m].
        """
        lower, upper = (self._corners[: self._count] @ (1.0, 1j)).T
        middles, sizes = turns * (0.5 * (lower + upper)) + shifts, 0.5 * np.abs(upper - lower)
        # The bounding box of a rotated box is larger than its bounding circle.
        reach = np.sqrt(2.0) * (sizes[index] + radius) + sizes
        return np.flatnonzero(np.abs(middles - middles[index]) <= 1.0001 * reach)
