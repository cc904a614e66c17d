"""The dots of all pieces, on a shelf: here, only where they lie and what was looked at last is in memory."""

from __future__ import annotations

from collections import OrderedDict

import numpy as np
from numpy.typing import NDArray

from floor_localizer.core.survey.dot_matching import DotField
from floor_localizer.core.survey.shelf import Shelf
from shirube_geometry import PlanarPose

_MOST_KEPT = 64


class PieceFields:
    """Dots of pieces, each in its own frame, that others are laid on."""

    def __init__(self, shelf: Shelf) -> None:
        """Begin without a piece."""
        self._shelf = shelf
        self._kept: OrderedDict[int, DotField] = OrderedDict()
        self._lower: list[NDArray[np.float64]] = []
        self._upper: list[NDArray[np.float64]] = []

    def append(self, dots: NDArray[np.float64]) -> None:
        """Add the dots of the next piece, shape (n, 2) [m], n >= 1."""
        self._shelf.put('piece', len(self._lower), dots)
        self._lower.append(dots.min(axis=0))
        self._upper.append(dots.max(axis=0))

    def dots(self, index: int) -> NDArray[np.float64]:
        """Return the dots of a piece, shape (n, 2) [m]."""
        (dots,) = self._shelf.get('piece', index)
        return dots

    def __getitem__(self, index: int) -> DotField:
        """Return the dots of a piece, sorted."""
        if index not in self._kept:
            self._kept[index] = DotField(self.dots(index))
            if len(self._kept) > _MOST_KEPT:
                self._kept.popitem(last=False)
        self._kept.move_to_end(index)
        return self._kept[index]

    def may_overlap(self, index: int, other: int, pose: PlanarPose, radius: float) -> bool:
        """Tell whether the box around a piece may touch that of another one.

        Args:
            index: of the piece.
            other: index of the other one.
            pose: of the piece in the frame of the other one.
            radius: how far it may be from there [m].
        """
        placed = pose.transform(self[index].points)
        return bool(
            (placed.min(axis=0) - radius < self._upper[other]).all()
            and (placed.max(axis=0) + radius > self._lower[other]).all()
        )

    def near(
        self, index: int, turns: NDArray[np.complex128], shifts: NDArray[np.complex128], radius: float
    ) -> NDArray[np.int64]:
        """Return all pieces that `may_overlap` could be true of, and some others, by circles around the boxes.

        Args:
            index: of a piece.
            turns: shape (n,), where the pieces lie: of magnitude 1.
            shifts: shape (n,) [m].
            radius: how far the piece may be from there [m].
        """
        lower, upper = np.array(self._lower) @ (1.0, 1j), np.array(self._upper) @ (1.0, 1j)
        middles, sizes = turns * (0.5 * (lower + upper)) + shifts, 0.5 * np.abs(upper - lower)
        # The box of a turned box reaches farther than its circle.
        reach = np.sqrt(2.0) * (sizes[index] + radius) + sizes
        return np.flatnonzero(np.abs(middles - middles[index]) <= 1.0001 * reach)
