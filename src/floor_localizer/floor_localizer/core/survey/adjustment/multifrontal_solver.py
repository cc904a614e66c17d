"""Out-of-core multifrontal solver of the normal equations (nested dissection).

The equations come in parts, one for each block of dots, over the images that observe its dots. Neighbouring parts are
merged in pairs up a binary tree, whose node of level k merges 2^k parts, and an image that is in no other part is
eliminated at once:

    U^T U = A_11,   X = U^-T A_12,   y = U^-T g_1,   A_22 - X^T X,   g_2 - X^T y

The factors U, X, y are kept in the array store until back substitution, x_1 = U^-1 (y - X x_2). Memory holds only the
front, the images along the boundary of the merged parts. Different branches of the tree are independent tasks.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from functools import partial

import numpy as np
from scipy.linalg import cholesky
from scipy.linalg.lapack import dtrtri

from floor_localizer.core.arrays import Floats, Ints
from floor_localizer.core.independent_tasks import TaskRunner, run_indexed
from floor_localizer.core.survey.array_store import ArrayStore

UNKNOWNS_PER_IMAGE = 6
# OpenBLAS uses several threads from 64 rows of a factor and from 64 * 64 * 64 products on.
_TILE = 60


@dataclass(frozen=True)
class NormalEquations:
    """Normal equations of images, ascending, (k,): symmetric matrix, (6 k, 6 k), and gradient, (6 k,)."""

    images: Ints
    normal: Floats
    gradient: Floats

    def __add__(self, other: NormalEquations) -> NormalEquations:
        """Return the sum of both, over the union of their images."""
        images = np.union1d(self.images, other.images)
        total = NormalEquations(
            images,
            np.zeros((UNKNOWNS_PER_IMAGE * len(images), UNKNOWNS_PER_IMAGE * len(images))),
            np.zeros(UNKNOWNS_PER_IMAGE * len(images)),
        )
        for each in (self, other):
            rows = unknown_indices(np.searchsorted(images, each.images))
            total.normal[np.ix_(rows, rows)] += each.normal
            total.gradient[rows] += each.gradient
        return total


def unknown_indices(images: Ints) -> Ints:
    """Return the indices of the unknowns of images, shape (6 k,)."""
    return (UNKNOWNS_PER_IMAGE * images[:, None] + np.arange(UNKNOWNS_PER_IMAGE)).ravel()


def eliminate_leading(normal: Floats, gradient: Floats, count: int) -> None:
    """Eliminate the first unknowns, in place.

    Args:
        normal: symmetric normal matrix, shape (n, n); only the upper triangle is used and overwritten: the upper rows
            with U, where U^T U = A_11 (its diagonal tiles inverted), and X = U^-T A_12; the lower rows with the Schur
            complement A_22 - X^T X.
        gradient: gradient, shape (n,); overwritten with y = U^-T g_1 and g_2 - X^T y.
        count: number of unknowns to eliminate.
    """
    size = len(normal)
    for begin in range(0, count, _TILE):
        tile = slice(begin, min(begin + _TILE, count))
        # With the inverse of the diagonal tile, all remaining steps are matrix products.
        normal[tile, tile], _ = dtrtri(cholesky(normal[tile, tile], check_finite=False))
        inverse = normal[tile, tile].T.copy()
        gradient[tile] = inverse @ gradient[tile]
        trailing = [slice(k, min(k + _TILE, size)) for k in range(tile.stop, size, _TILE)]
        for column in trailing:
            normal[tile, column] = inverse @ normal[tile, column]
            gradient[column] -= gradient[tile] @ normal[tile, column]
        for k, row in enumerate(trailing):
            panel = normal[tile, row].T.copy()
            for column in trailing[k:]:
                normal[row, column] -= panel @ normal[tile, column]


def back_substitute(upper: Floats, y: Floats, known: Floats) -> Floats:
    """Return the eliminated unknowns, shape (count,), given the others, shape (n - count,).

    ``upper``, shape (count, n), and ``y``, shape (count,), are the first rows of what `eliminate_leading` writes.
    """
    count = len(y)
    solution = y - np.einsum('ij,j->i', upper[:, count:], known)
    for begin in range(_TILE * ((count - 1) // _TILE), -1, -_TILE):
        tile = slice(begin, min(begin + _TILE, count))
        solution[tile] = upper[tile, tile] @ solution[tile]
        solution[:begin] -= np.einsum('ij,j->i', upper[:begin, tile], solution[tile])
    return solution


_SUBTREE_LEVELS = 3  # levels of the tree in one task, so eight parts: large enough to hide the overhead of scheduling


@dataclass(frozen=True)
class PartialSolution:
    """Solved unknowns, (k, 6), of some images, ascending indices, (k,)."""

    images: Ints
    values: Floats

    def merge(self, other: PartialSolution) -> PartialSolution:
        """Return the union with the solution of other images."""
        images = np.concatenate([self.images, other.images])
        order = np.argsort(images)
        return PartialSolution(images[order], np.concatenate([self.values, other.values])[order])

    def unknowns_of_images(self, images: Ints) -> Floats:
        """Return the solved unknowns of some images, shape (6 j,)."""
        return self.values[np.searchsorted(self.images, images)].ravel()


EMPTY_SOLUTION = PartialSolution(np.empty(0, dtype=np.int64), np.empty((0, UNKNOWNS_PER_IMAGE)))


@dataclass(frozen=True)
class EliminationTree:
    """Elimination tree; factors and Schur complements of its nodes are in an array store.

    Attributes:
        parts: number of parts.
        store: array store of the factors, the Schur complements and the spans of the images.
    """

    parts: int
    store: ArrayStore

    def node_count(self, level: int) -> int:
        """Return the number of nodes of a level."""
        return -(-self.parts >> level)

    def children(self, level: int, index: int) -> range:
        """Return the children of a node: two, or one at the end of a level."""
        return range(2 * index, min(2 * index + 2, self.node_count(level - 1))) if level else range(0)

    def eliminate_subtree(self, level: int, index: int, part: Callable[[int], NormalEquations]) -> NormalEquations:
        """Return the Schur complement of a node after eliminating its whole subtree."""
        if level == 0:
            return self._eliminate(level, index, part(index))
        return self.merge_children(level, index, lambda child: self.eliminate_subtree(level - 1, child, part))

    def merge_children(self, level: int, index: int, complement: Callable[[int], NormalEquations]) -> NormalEquations:
        """Return the Schur complement of a node from those of its children, which are loaded when needed."""
        child_nodes = self.children(level, index)
        if len(child_nodes) == 1:
            return complement(child_nodes[0])
        # No reference keeps the children or their sum in memory during the elimination.
        return self._eliminate(level, index, complement(child_nodes[0]) + complement(child_nodes[1]))

    def store_complement(self, level: int, index: int, complement: NormalEquations) -> None:
        """Store the Schur complement of a node."""
        self.store.put(f'complement{level}', index, complement.images, complement.normal, complement.gradient)

    def load_complement(self, level: int, index: int) -> NormalEquations:
        """Load the Schur complement of a node."""
        return NormalEquations(*self.store.get(f'complement{level}', index))

    def solve(self, level: int, index: int, known: PartialSolution) -> PartialSolution:
        """Return the unknowns of the images eliminated at a node, by back substitution, given those of all above it."""
        if level and len(self.children(level, index)) == 1:
            return EMPTY_SOLUTION
        images, others, upper, y = self.store.get(f'factor{level}', index)
        return PartialSolution(
            images, back_substitute(upper, y, known.unknowns_of_images(others)).reshape(-1, UNKNOWNS_PER_IMAGE)
        )

    def solve_subtree(self, level: int, index: int, known: PartialSolution) -> list[PartialSolution]:
        """Return the unknowns of the images eliminated at a node and below it; arguments as for `solve`."""
        found = self.solve(level, index, known)
        known = known.merge(found)
        child_nodes = [self.solve_subtree(level - 1, child, known) for child in self.children(level, index)]
        return [found, *(each for solutions in child_nodes for each in solutions)]

    def _eliminate(self, level: int, index: int, part: NormalEquations) -> NormalEquations:
        """Eliminate the images that are only in parts below the node; store their factor, return the complement."""
        all_images, spans = part.images, self.store.memory_map('spans')[part.images]
        is_eliminated = (spans[:, 0] >= index << level) & (spans[:, 1] < (index + 1) << level)
        order = np.argsort(~is_eliminated, kind='stable')
        rows, count = unknown_indices(order), UNKNOWNS_PER_IMAGE * int(is_eliminated.sum())
        normal, gradient = part.normal[np.ix_(rows, rows)], part.gradient[rows]
        del part
        eliminate_leading(normal, gradient, count)
        images, others = all_images[is_eliminated], all_images[~is_eliminated]
        self.store.put(f'factor{level}', index, images, others, normal[:count], gradient[:count])
        complement = np.triu(normal[count:, count:])
        del normal
        complement += np.triu(complement, 1).T
        return NormalEquations(others, complement, gradient[count:])


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

    def set_spans(self, spans: Ints) -> None:
        """Store the first and the last part that contain each image, shape (n, 2)."""
        self.store.put('spans', 0, spans)

    def solve(self, part: Callable[[int], NormalEquations]) -> Floats:
        """Return the solution, shape (n, 6); 0 for an image that is in no part.

        ``part`` returns the equations of a part, also in another process; their sum is positive definite.
        """
        tree, root_level = EliminationTree(self.parts, self.store), _SUBTREE_LEVELS
        subtrees = tree.node_count(_SUBTREE_LEVELS)
        run_indexed(self.runner, partial(_eliminate_subtree, tree, part), subtrees)
        while tree.node_count(root_level) > 1:
            root_level += 1
            run_indexed(self.runner, partial(_merge_nodes, tree, root_level), tree.node_count(root_level))
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
        run_indexed(self.runner, partial(_solve_subtree, tree), subtrees)
        for index in range(subtrees):
            images, values = self.store.get('found', index)
            solution[images] = values
        return solution


def _eliminate_subtree(tree: EliminationTree, part: Callable[[int], NormalEquations], index: int) -> None:
    tree.store_complement(_SUBTREE_LEVELS, index, tree.eliminate_subtree(_SUBTREE_LEVELS, index, part))


def _merge_nodes(tree: EliminationTree, level: int, index: int) -> None:
    complement = tree.merge_children(level, index, partial(tree.load_complement, level - 1))
    tree.store_complement(level, index, complement)


def _solve_subtree(tree: EliminationTree, index: int) -> None:
    known = PartialSolution(*tree.store.get('known', index))
    found = EMPTY_SOLUTION
    for each in tree.solve_subtree(_SUBTREE_LEVELS, index, known):
        found = found.merge(each)
    tree.store.put('found', index, found.images, found.values)
