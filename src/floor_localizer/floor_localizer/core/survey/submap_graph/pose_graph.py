"""Pose graph of the submaps: least squares over similarities a z + b of the plane.

An edge between two submaps is a set of shared dots, z in one and w in the other, with the constraint

    a_i z + b_i = a_j w + b_j,

which is linear in the complex a and b. A prior w |a - a/|a||^2, relinearised each iteration, keeps |a|, the scale of a
submap, near 1. One submap, or the map to extend, is fixed.

It is optimised while submaps are added. A new submap is aligned to its edges. If a small residual is left, a sliding
window of the last submaps is optimised. The whole graph is optimised if that is not enough, if the residual of a loop
closure is large, and whenever the number of submaps has grown by a fraction, so that the total work is linear in their
number.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np
from scipy import sparse
from scipy.sparse.csgraph import connected_components
from scipy.sparse.linalg import splu

from floor_localizer.core.arrays import Booleans, Complexes, Ints

_ITERATIONS = 4
_MAX_DOTS = 30
# Standard deviation of the scale of a submap, the average over its images.
_SCALE_SIGMA = 0.005
DOT_SIGMA = 0.0002  # standard deviation of a dot in a submap, which may be slightly bent [m]
_SMALL_RESIDUAL, _LARGE_RESIDUAL = 0.001, 0.005
"""Residual of an edge above which the window, and above which the whole graph is optimised [m]."""
_OPTIMIZE_EVERY, _OPTIMIZE_FRACTION = 8, 0.1
_WINDOW = 64  # number of submaps in the sliding window


@dataclass(frozen=True)
class PoseGraphEdge:
    """Edge of the pose graph: dots shared by two submaps.

    Attributes:
        first: index of the first submap.
        second: index of the second submap.
        points_first: shared dots in the frame of the first submap, complex, shape (k,) [m].
        points_second: the same dots in the frame of the second submap, complex, shape (k,) [m].
        is_loop_closure: whether the edge is a loop closure: the submaps are not consecutive.
    """

    first: int
    second: int
    points_first: Complexes
    points_second: Complexes
    is_loop_closure: bool

    def subsample(self) -> PoseGraphEdge:
        """Return the edge with at most as many dots as `optimize_pose_graph` uses."""
        if len(self.points_first) <= _MAX_DOTS:
            return self
        chosen = np.linspace(0, len(self.points_first) - 1, min(len(self.points_first), _MAX_DOTS)).astype(int)
        return replace(self, points_first=self.points_first[chosen], points_second=self.points_second[chosen])


def optimize_pose_graph(
    rotations: Complexes,
    translations: Complexes,
    submaps: Ints,
    edges: Sequence[PoseGraphEdge],
    free: Booleans,
    sigma: float,
) -> tuple[Complexes, Complexes]:
    """Return the optimised similarities of submaps.

    Args:
        rotations: initial values of a, shape (n,).
        translations: initial values of b, shape (n,) [m].
        submaps: indices of the submaps, ascending, shape (n,).
        edges: edges between them.
        free: whether each submap is optimised, shape (n,); the others are fixed.
        sigma: standard deviation of a shared dot [m].
    """
    A = _residual_matrix(submaps, edges) / sigma
    state = np.column_stack([rotations, translations]).ravel()
    is_free = np.repeat(free, 2)
    weight = np.tile([_SCALE_SIGMA**-2, 1e-6], len(rotations))
    normal = (A.conj().T @ A + sparse.diags(weight)).tocsc()
    # The options for a matrix that is Hermitian and positive definite.
    options = {'SymmetricMode': True}
    factor = splu(normal[is_free][:, is_free], 'MMD_AT_PLUS_A', diag_pivot_thresh=0.0, options=options)
    known = normal[is_free][:, ~is_free] @ state[~is_free]
    for _ in range(_ITERATIONS):
        prior = weight * state
        prior[0::2] /= np.abs(state[0::2])
        state[is_free] = factor.solve(prior[is_free] - known)
    return state[0::2].copy(), state[1::2].copy()


def _residual_matrix(submaps: Ints, edges: Sequence[PoseGraphEdge]) -> sparse.csr_matrix:
    """Return the Jacobian of the differences between shared dots by all a, b."""
    subsampled = [edge.subsample() for edge in edges]
    counts = [len(edge.points_first) for edge in subsampled]
    first, second = (
        np.repeat(2 * np.searchsorted(submaps, submap_indices), counts)
        for submap_indices in ([edge.first for edge in subsampled], [edge.second for edge in subsampled])
    )
    z, w = (
        np.concatenate(dots)
        for dots in ([edge.points_first for edge in subsampled], [edge.points_second for edge in subsampled])
    )
    one = np.ones(len(z))
    rows = np.tile(np.arange(len(z)), 4)
    columns = np.concatenate([first, first + 1, second, second + 1])
    values = np.concatenate([z, one, -w, -one])
    return sparse.csr_matrix((values, (rows, columns)), shape=(len(z), 2 * len(submaps)))


def component_labels(count: int, edges: Sequence[PoseGraphEdge]) -> Ints:
    """Return the label of the connected component of each submap, shape (count,)."""
    submap_indices = np.array([(edge.first, edge.second) for edge in edges], dtype=np.int64).reshape(-1, 2)
    matrix = sparse.coo_matrix((np.ones(len(submap_indices)), submap_indices.T), shape=(count, count))
    return connected_components(matrix, directed=False)[1].astype(np.int64)


class SubmapPoses:
    """Similarities a z + b of the submaps in the map frame (``rotations``, ``translations`` [m]), and their edges."""

    def __init__(self) -> None:
        """Begin without a submap."""
        self.rotations: list[complex] = []
        self.translations: list[complex] = []
        self.edges: list[PoseGraphEdge] = []
        self._edges_of: list[list[PoseGraphEdge]] = []
        self._added_since_optimized = 0

    def append(self, rotation: complex, translation: complex) -> None:
        """Add a submap."""
        self.rotations.append(rotation)
        self.translations.append(translation)
        self._edges_of.append([])

    def add_edges(self, edges: Sequence[PoseGraphEdge]) -> None:
        """Add edges of the last submap, align it to them, and optimise the graph if a residual is left."""
        if not edges:
            return
        subsampled = [edge.subsample() for edge in edges]
        self.edges += subsampled
        self._edges_of[-1] += subsampled
        self._added_since_optimized += 1
        count = len(self.rotations)
        residual = self.align(edges)
        if _SMALL_RESIDUAL < residual < _LARGE_RESIDUAL:
            self._optimize_from(max(count - _WINDOW, 1))
            residual = self._max_residual(edges)
        if residual > _SMALL_RESIDUAL or self._added_since_optimized >= max(
            _OPTIMIZE_EVERY, _OPTIMIZE_FRACTION * count
        ):
            self.optimize()

    def align(self, edges: Sequence[PoseGraphEdge]) -> float:
        """Align the second submap of some edges to them; return the largest remaining residual [m]."""
        own_points = np.concatenate([edge.points_second for edge in edges])
        other_points = np.concatenate(
            [self.rotations[edge.first] * edge.points_first + self.translations[edge.first] for edge in edges]
        )
        centred = own_points - own_points.mean()
        rotation = np.vdot(centred, other_points - other_points.mean())
        rotation /= abs(rotation)
        index, translation = edges[0].second, other_points.mean() - rotation * own_points.mean()
        self.rotations[index], self.translations[index] = complex(rotation), complex(translation)
        return self._max_residual(edges)

    def optimize(self) -> None:
        """Optimise all submaps but the first."""
        self._added_since_optimized = 0
        self._optimize_from(1)

    def arrays(self) -> tuple[Complexes, Complexes]:
        """Return the similarities, shape (n,) each."""
        return np.array(self.rotations), np.array(self.translations)

    def _optimize_from(self, begin: int) -> None:
        """Optimise the submaps from one on; the others are fixed."""
        edges = [edge for submap_edges in self._edges_of[begin:] for edge in submap_edges]
        if not edges:
            return
        submaps = np.unique([(edge.first, edge.second) for edge in edges])
        rotations, translations = (np.array(each)[submaps] for each in (self.rotations, self.translations))
        rotations, translations = optimize_pose_graph(
            rotations, translations, submaps, edges, submaps >= begin, DOT_SIGMA
        )
        for submap, rotation, translation in zip(
            submaps.tolist(), rotations.tolist(), translations.tolist(), strict=True
        ):
            self.rotations[submap], self.translations[submap] = rotation, translation

    def _max_residual(self, edges: Sequence[PoseGraphEdge]) -> float:
        return max(
            float(np.abs(
                self.rotations[edge.first] * edge.points_first + self.translations[edge.first]
                - self.rotations[edge.second] * edge.points_second - self.translations[edge.second]
            ).max())
            for edge in edges
        )  # fmt: skip
