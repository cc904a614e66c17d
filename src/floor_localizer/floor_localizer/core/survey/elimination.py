"""Out-of-core multifrontal solver of the normal equations (nested dissection).

The equations come in parts, one for each block of dots, over the images that observe its dots. Neighbouring parts are
merged in pairs up a binary tree (see `elimination_tree`), and an image that is in no other part is eliminated at once:

    U^T U = A_11,   X = U^-T A_12,   y = U^-T g_1,   A_22 - X^T X,   g_2 - X^T y

The factors U, X, y are kept in the array store until back substitution, x_1 = U^-1 (y - X x_2). Memory holds only the
front, the images along the boundary of the merged parts. Different branches of the tree are independent tasks.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from functools import partial

import numpy as np
from numpy.typing import NDArray

from floor_localizer.core.independent_tasks import TaskRunner, run_numbered
from floor_localizer.core.survey.elimination_tree import NOTHING, EliminationTree, Known
from floor_localizer.core.survey.equations import UNKNOWNS, Equations
from floor_localizer.core.survey.shelf import Shelf

_BRANCH = 3
"""Levels of the tree in one task, so eight parts: large enough to hide the overhead of scheduling."""


@dataclass(frozen=True)
class Elimination:
    """Solves normal equations whose parts always contain the same images.

    Attributes:
        images: number of all images.
        parts: number of parts.
        shelf: array store of the factors; the tasks must see it.
        runner: runs the tasks.
    """

    images: int
    parts: int
    shelf: Shelf
    runner: TaskRunner

    def begin(self, spans: NDArray[np.int64]) -> None:
        """Store the first and the last part that contain each image, shape (n, 2)."""
        self.shelf.put('spans', 0, spans)

    def solve(self, part: Callable[[int], Equations]) -> NDArray[np.float64]:
        """Return the solution, shape (n, 6); 0 for an image that is in no part.

        Args:
            part: returns the equations of a part, also in another process; their sum is positive definite.
        """
        tree, top = EliminationTree(self.parts, self.shelf), _BRANCH
        branches = tree.width(_BRANCH)
        run_numbered(self.runner, _Branch(tree, part), branches)
        while tree.width(top) > 1:
            top += 1
            run_numbered(self.runner, _Join(tree, top), tree.width(top))
        solution = np.zeros((self.images, UNKNOWNS))
        waiting = [(top, 0, NOTHING)]
        while waiting:
            level, index, known = waiting.pop()
            if level == _BRANCH:
                self.shelf.put('known', index, known.images, known.values)
                continue
            found = tree.solve(level, index, known)
            solution[found.images] = found.values
            known = known.with_more(found)
            waiting += [(level - 1, child, known) for child in tree.children(level, index)]
        run_numbered(self.runner, _WayBack(tree), branches)
        for index in range(branches):
            images, values = self.shelf.get('found', index)
            solution[images] = values
        return solution


@dataclass(frozen=True)
class _Branch:
    tree: EliminationTree
    part: Callable[[int], Equations]

    def __call__(self, index: int) -> None:
        self.tree.put_rest(_BRANCH, index, self.tree.rest_below(_BRANCH, index, self.part))


@dataclass(frozen=True)
class _Join:
    tree: EliminationTree
    level: int

    def __call__(self, index: int) -> None:
        rest = self.tree.join(self.level, index, partial(self.tree.get_rest, self.level - 1))
        self.tree.put_rest(self.level, index, rest)


@dataclass(frozen=True)
class _WayBack:
    tree: EliminationTree

    def __call__(self, index: int) -> None:
        known = Known(*self.tree.shelf.get('known', index))
        found = NOTHING
        for each in self.tree.solve_below(_BRANCH, index, known):
            found = found.with_more(each)
        self.tree.shelf.put('found', index, found.images, found.values)
