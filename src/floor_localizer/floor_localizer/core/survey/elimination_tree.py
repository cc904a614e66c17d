"""Binary elimination tree: a node of level k merges 2^k neighbouring parts of the normal equations."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from floor_localizer.core.survey.equations import UNKNOWNS, Equations, unknowns_of
from floor_localizer.core.survey.partial_cholesky import eliminate_first, way_back
from floor_localizer.core.survey.shelf import Shelf


@dataclass(frozen=True)
class Known:
    """Solved unknowns of some images.

    Attributes:
        images: indices of the images, ascending, shape (k,).
        values: solved unknowns, shape (k, 6).
    """

    images: NDArray[np.int64]
    values: NDArray[np.float64]

    def with_more(self, other: Known) -> Known:
        """Return the union with the solution of other images."""
        images = np.concatenate([self.images, other.images])
        order = np.argsort(images)
        return Known(images[order], np.concatenate([self.values, other.values])[order])

    def of(self, images: NDArray[np.int64]) -> NDArray[np.float64]:
        """Return the solved unknowns of some images, shape (6 j,)."""
        return self.values[np.searchsorted(self.images, images)].ravel()


NOTHING = Known(np.empty(0, dtype=np.int64), np.empty((0, UNKNOWNS)))


@dataclass(frozen=True)
class EliminationTree:
    """Elimination tree; factors and Schur complements of its nodes are in an array store.

    Attributes:
        parts: number of parts.
        shelf: array store of the factors, the Schur complements and the spans of the images.
    """

    parts: int
    shelf: Shelf

    def width(self, level: int) -> int:
        """Return the number of nodes of a level."""
        return -(-self.parts >> level)

    def children(self, level: int, index: int) -> range:
        """Return the children of a node: two, or one at the end of a level."""
        return range(2 * index, min(2 * index + 2, self.width(level - 1))) if level else range(0)

    def rest_below(self, level: int, index: int, part: Callable[[int], Equations]) -> Equations:
        """Return the Schur complement of a node after eliminating its whole subtree."""
        if level == 0:
            return self._eliminate(level, index, part(index))
        return self.join(level, index, lambda child: self.rest_below(level - 1, child, part))

    def join(self, level: int, index: int, rest: Callable[[int], Equations]) -> Equations:
        """Return the Schur complement of a node from those of its children, which are loaded when needed."""
        below = self.children(level, index)
        if len(below) == 1:
            return rest(below[0])
        # No reference keeps the children or their sum in memory during the elimination.
        return self._eliminate(level, index, rest(below[0]) + rest(below[1]))

    def put_rest(self, level: int, index: int, rest: Equations) -> None:
        """Store the Schur complement of a node."""
        self.shelf.put(f'rest{level}', index, rest.images, rest.normal, rest.gradient)

    def get_rest(self, level: int, index: int) -> Equations:
        """Load the Schur complement of a node."""
        return Equations(*self.shelf.get(f'rest{level}', index))

    def solve(self, level: int, index: int, known: Known) -> Known:
        """Return the unknowns of the images eliminated at a node, by back substitution.

        Args:
            level: level of the node.
            index: index of the node in its level.
            known: solution of all images eliminated above the node.
        """
        if level and len(self.children(level, index)) == 1:
            return NOTHING
        images, others, upper, y = self.shelf.get(f'left{level}', index)
        return Known(images, way_back(upper, y, known.of(others)).reshape(-1, UNKNOWNS))

    def solve_below(self, level: int, index: int, known: Known) -> list[Known]:
        """Return the unknowns of the images eliminated at a node and below it; arguments as for `solve`."""
        found = self.solve(level, index, known)
        known = known.with_more(found)
        below = [self.solve_below(level - 1, child, known) for child in self.children(level, index)]
        return [found, *(each for several in below for each in several)]

    def _eliminate(self, level: int, index: int, part: Equations) -> Equations:
        """Eliminate the images that are only in parts below the node; store their factor, return the complement."""
        all_images, spans = part.images, self.shelf.look_up('spans')[part.images]
        leaves = (spans[:, 0] >= index << level) & (spans[:, 1] < (index + 1) << level)
        order = np.argsort(~leaves, kind='stable')
        rows, count = unknowns_of(order), UNKNOWNS * int(leaves.sum())
        normal, gradient = part.normal[np.ix_(rows, rows)], part.gradient[rows]
        del part
        eliminate_first(normal, gradient, count)
        images, others = all_images[leaves], all_images[~leaves]
        self.shelf.put(f'left{level}', index, images, others, normal[:count], gradient[:count])
        rest = np.triu(normal[count:, count:])
        del normal
        rest += np.triu(rest, 1).T
        return Equations(others, rest, gradient[count:])
