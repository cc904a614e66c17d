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

from floor_localizer.core.independent_tasks import TaskRunner, run_indexed
from floor_localizer.core.survey.array_store import ArrayStore
from floor_localizer.core.survey.elimination_tree import EMPTY_SOLUTION, EliminationTree, PartialSolution
from floor_localizer.core.survey.normal_equations import UNKNOWNS_PER_IMAGE, NormalEquations

_SUBTREE_LEVELS = 3
"""Levels of the tree in one task, so eight parts: large enough to hide the overhead of scheduling."""


@dataclass(frozen=True)
class MultifrontalSolver:
    """Solves normal equations whose parts always contain the same images.

    Attributes:
        images: number of all images.
        parts: number of parts.
        store: array store of the factors; the tasks must see it.
        runner: runs the tasks.
    """

    images: int
    parts: int
    store: ArrayStore
    runner: TaskRunner

    def set_spans(self, spans: NDArray[np.int64]) -> None:
        """Store the first and the last part that contain each image, shape (n, 2)."""
        self.store.put('spans', 0, spans)

    def solve(self, part: Callable[[int], NormalEquations]) -> NDArray[np.float64]:
        """Return the solution, shape (n, 6); 0 for an image that is in no part.

        Args:
            part: returns the equations of a part, also in another process; their sum is positive definite.
        """
        tree, root_level = EliminationTree(self.parts, self.store), _SUBTREE_LEVELS
        subtrees = tree.node_count(_SUBTREE_LEVELS)
        run_indexed(self.runner, _SubtreeTask(tree, part), subtrees)
        while tree.node_count(root_level) > 1:
            root_level += 1
            run_indexed(self.runner, _MergeTask(tree, root_level), tree.node_count(root_level))
        solution = np.zeros((self.images, UNKNOWNS_PER_IMAGE))
        pending = [(root_level, 0, EMPTY_SOLUTION)]
        while pending:
            level, index, known = pending.pop()
            if level == _SUBTREE_LEVELS:
                self.store.put('known', index, known.images, known.values)
                continue
            found = tree.solve(level, index, known)
            solution[found.images] = found.values
            known = known.merge(found)
            pending += [(level - 1, child, known) for child in tree.children(level, index)]
        run_indexed(self.runner, _BackSubstitutionTask(tree), subtrees)
        for index in range(subtrees):
            images, values = self.store.get('found', index)
            solution[images] = values
        return solution


@dataclass(frozen=True)
class _SubtreeTask:
    tree: EliminationTree
    part: Callable[[int], NormalEquations]

    def __call__(self, index: int) -> None:
        self.tree.store_complement(
            _SUBTREE_LEVELS, index, self.tree.eliminate_subtree(_SUBTREE_LEVELS, index, self.part)
        )


@dataclass(frozen=True)
class _MergeTask:
    tree: EliminationTree
    level: int

    def __call__(self, index: int) -> None:
        complement = self.tree.merge_children(
            self.level, index, partial(self.tree.load_complement, self.level - 1)
        )
        self.tree.store_complement(self.level, index, complement)


@dataclass(frozen=True)
class _BackSubstitutionTask:
    tree: EliminationTree

    def __call__(self, index: int) -> None:
        known = PartialSolution(*self.tree.store.get('known', index))
        found = EMPTY_SOLUTION
        for each in self.tree.solve_subtree(_SUBTREE_LEVELS, index, known):
            found = found.merge(each)
        self.tree.store.put('found', index, found.images, found.values)
