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
        # Of the pieces so far and some to come: the lower and the upper corner of each.
        self._corners = np.empty((_MOST_KEPT, 2, 2))
        self._count = 0

    def append(self, dots: NDArray[np.float64]) -> None:
        """Add the dots of the next piece, shape (n, 2) [m], n >= 1."""
        if self._count == len(self._corners):
            self._corners = np.concatenate([self._corners, np.empty_like(self._corners)])
        self._shelf.put('piece', self._count, dots)
        self._corners[self._count] = dots.min(axis=0), dots.max(axis=0)
        self._count += 1

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
        placed, (lower, upper) = pose.transform(self[index].points), self._corners[other]
        return bool(
            (placed.min(axis=0) - radius < upper).all() and (placed.max(axis=0) + radius > lower).all()
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
        lower, upper = (self._corners[: self._count] @ (1.0, 1j)).T
        middles, sizes = turns * (0.5 * (lower + upper)) + shifts, 0.5 * np.abs(upper - lower)
        # The box of a turned box reaches farther than its circle.
        reach = np.sqrt(2.0) * (sizes[index] + radius) + sizes
        return np.flatnonzero(np.abs(middles - middles[index]) <= 1.0001 * reach)
