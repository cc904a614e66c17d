"""The tree by which equations are joined: below a node of level k are 2^k parts side by side."""

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
    """Unknowns that have been found.

    Attributes:
        images: shape (k,), indices of their images, rising.
        values: shape (k, 6).
    """

    images: NDArray[np.int64]
    values: NDArray[np.float64]

    def with_more(self, other: Known) -> Known:
        """Return these and others, of other images."""
        images = np.concatenate([self.images, other.images])
        order = np.argsort(images)
        return Known(images[order], np.concatenate([self.values, other.values])[order])

    def of(self, images: NDArray[np.int64]) -> NDArray[np.float64]:
        """Return the unknowns of images that are known, shape (6 j,)."""
        return self.values[np.searchsorted(self.images, images)].ravel()


NOTHING = Known(np.empty(0, dtype=np.int64), np.empty((0, UNKNOWNS)))


@dataclass(frozen=True)
class EliminationTree:
    """What lies at the nodes of the tree, on a shelf on which the spans of the images are.

    Attributes:
        parts: number of the parts.
        shelf: of what has left and of what is left.
    """

    parts: int
    shelf: Shelf

    def width(self, level: int) -> int:
        """Return the number of nodes of a level."""
        return -(-self.parts >> level)

    def children(self, level: int, index: int) -> range:
        """Return the nodes of the level below that lie below a node: two, at the end perhaps one."""
        return range(2 * index, min(2 * index + 2, self.width(level - 1))) if level else range(0)

    def rest_below(self, level: int, index: int, part: Callable[[int], Equations]) -> Equations:
        """Return what is left of the parts below a node when all images have left that are in no others."""
        if level == 0:
            return self._eliminate(level, index, part(index))
        return self.join(level, index, lambda child: self.rest_below(level - 1, child, part))

    def join(self, level: int, index: int, rest: Callable[[int], Equations]) -> Equations:
        """Return what is left at a node of what is left at its children, which are asked for when they are needed."""
        below = self.children(level, index)
        if len(below) == 1:
            return rest(below[0])
        # Nothing here keeps the children's or their sum in memory while images leave.
        return self._eliminate(level, index, rest(below[0]) + rest(below[1]))

    def put_rest(self, level: int, index: int, rest: Equations) -> None:
        """Put away what is left at a node."""
        self.shelf.put(f'rest{level}', index, rest.images, rest.normal, rest.gradient)

    def get_rest(self, level: int, index: int) -> Equations:
        """Return what is left at a node."""
        return Equations(*self.shelf.get(f'rest{level}', index))

    def solve(self, level: int, index: int, known: Known) -> Known:
        """Return the unknowns of the images that have left at a node.

        Args:
            level: of the node.
            index: its number there.
            known: those of all images that have left above it.
        """
        if level and len(self.children(level, index)) == 1:
            return NOTHING
        images, others, upper, y = self.shelf.get(f'left{level}', index)
        return Known(images, way_back(upper, y, known.of(others)).reshape(-1, UNKNOWNS))

    def solve_below(self, level: int, index: int, known: Known) -> list[Known]:
        """Return the unknowns of the images that have left at a node or below it; arguments as of `solve`."""
        found = self.solve(level, index, known)
        known = known.with_more(found)
        below = [self.solve_below(level - 1, child, known) for child in self.children(level, index)]
        return [found, *(each for several in below for each in several)]

    def _eliminate(self, level: int, index: int, part: Equations) -> Equations:
        """Return the equations without the images that are in no part but those below the node."""
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
