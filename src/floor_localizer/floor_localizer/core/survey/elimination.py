"""Normal equations that are too many for memory: solved by eliminating images as soon as nothing more is said of them.

The equations come in parts, one for each block of dots, and each knows only the images that see its dots. Parts that
lie side by side are joined two and two, then the pairs, and so on; an image that no other part sees leaves at once by

    U^T U = A_11,   X = U^-T A_12,   y = U^-T g_1,   A_22 - X^T X,   g_2 - X^T y

(nested dissection, with the blocks as its leaves). What has left lies on the shelf until the way back,
x_1 = U^-1 (y - X x_2). So memory holds the images along the edge of what is joined, not those within.
"""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from floor_localizer.core.survey.partial_cholesky import eliminate_first, way_back
from floor_localizer.core.survey.shelf import Shelf

UNKNOWNS = 6


@dataclass(frozen=True)
class Equations:
    """Normal equations of some images, with six unknowns each.

    Attributes:
        images: shape (k,), indices of the images, rising.
        normal: shape (6 k, 6 k), symmetric.
        gradient: shape (6 k,).
    """

    images: NDArray[np.int64]
    normal: NDArray[np.float64]
    gradient: NDArray[np.float64]

    def __add__(self, other: Equations) -> Equations:
        """Return the sum of both."""
        images = np.union1d(self.images, other.images)
        total = Equations(
            images,
            np.zeros((UNKNOWNS * len(images), UNKNOWNS * len(images))),
            np.zeros(UNKNOWNS * len(images)),
        )
        for each in (self, other):
            rows = unknowns_of(np.searchsorted(images, each.images))
            total.normal[np.ix_(rows, rows)] += each.normal
            total.gradient[rows] += each.gradient
        return total


def unknowns_of(images: NDArray[np.int64]) -> NDArray[np.int64]:
    """Return the indices of the unknowns of images, shape (6 k,)."""
    return (UNKNOWNS * images[:, None] + np.arange(UNKNOWNS)).ravel()


class Elimination:
    """Solves equations whose parts are always of the same images."""

    def __init__(self, first: NDArray[np.int64], last: NDArray[np.int64], shelf: Shelf) -> None:
        """Begin.

        Args:
            first: shape (n,), the number of the first part that each image is in.
            last: shape (n,), of the last one.
            shelf: for what has left.
        """
        self._first, self._last, self._shelf = first, last, shelf
        self._left = 0

    def solve(self, parts: Iterable[Equations]) -> NDArray[np.float64]:
        """Return the solution, shape (n, 6); 0 for an image that is in no part.

        Args:
            parts: in their order; their sum is positive definite.
        """
        self._left = 0
        waiting: list[tuple[int, Equations]] = []
        number = -1
        for number, part in enumerate(parts):
            waiting.append((number, self._eliminate(part, number, number)))
            halves = number + 1
            while halves % 2 == 0:
                self._join(waiting, number)
                halves //= 2
        while len(waiting) > 1:
            self._join(waiting, number)
        return self._way_back()

    def _join(self, waiting: list[tuple[int, Equations]], until: int) -> None:
        """Join the last two that are waiting."""
        _, second = waiting.pop()
        begin, first = waiting.pop()
        waiting.append((begin, self._eliminate(first + second, begin, until)))

    def _eliminate(self, part: Equations, begin: int, until: int) -> Equations:
        """Return the equations without the images that are in no part but those from ``begin`` to ``until``."""
        leaves = (self._first[part.images] >= begin) & (self._last[part.images] <= until)
        if not leaves.any():
            return part
        order = np.argsort(~leaves, kind='stable')
        rows, count = unknowns_of(order), UNKNOWNS * int(leaves.sum())
        normal, gradient = part.normal[np.ix_(rows, rows)], part.gradient[rows]
        eliminate_first(normal, gradient, count)
        images, others = part.images[leaves], part.images[~leaves]
        self._shelf.put('left', self._left, images, others, normal[:count], gradient[:count])
        self._left += 1
        rest = np.triu(normal[count:, count:])
        rest += np.triu(rest, 1).T
        return Equations(others, rest, gradient[count:])

    def _way_back(self) -> NDArray[np.float64]:
        solution = np.zeros((len(self._first), UNKNOWNS))
        for number in range(self._left - 1, -1, -1):
            images, others, upper, y = self._shelf.get('left', number)
            found = way_back(upper, y, solution[others].ravel())
            solution[images] = found.reshape(-1, UNKNOWNS)
        return solution
