"""Pose graph of the submaps: least squares over similarities a z + b of the plane.

An edge between two submaps is a set of shared dots, z in one and w in the other, with the constraint

    a_i z + b_i = a_j w + b_j,

which is linear in the complex a and b. A prior w |a - a/|a||^2, relinearised each iteration, keeps |a|, the scale of a
submap, near 1. One submap, or the map to extend, is fixed.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray
from scipy import sparse
from scipy.sparse.csgraph import connected_components
from scipy.sparse.linalg import SuperLU, splu

_ITERATIONS = 4
_MAX_DOTS = 30
# Standard deviation of the scale of a submap, the average over its images.
_SCALE_SIGMA = 0.005


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
    points_first: NDArray[np.complex128]
    points_second: NDArray[np.complex128]
    is_loop_closure: bool

    def subsample(self) -> PoseGraphEdge:
        """Return the edge with at most as many dots as `optimize_pose_graph` uses."""
        if len(self.points_first) <= _MAX_DOTS:
            return self
        chosen = np.linspace(0, len(self.points_first) - 1, min(len(self.points_first), _MAX_DOTS)).astype(
            int
        )
        return replace(self, points_first=self.points_first[chosen], points_second=self.points_second[chosen])


def optimize_pose_graph(
    rotations: NDArray[np.complex128],
    translations: NDArray[np.complex128],
    submaps: NDArray[np.int64],
    edges: Sequence[PoseGraphEdge],
    free: NDArray[np.bool_],
    sigma: float,
) -> tuple[NDArray[np.complex128], NDArray[np.complex128]]:
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
    factor = _factorise(normal[is_free][:, is_free])
    known = normal[is_free][:, ~is_free] @ state[~is_free]
    for _ in range(_ITERATIONS):
        prior = weight * state
        prior[0::2] /= np.abs(state[0::2])
        state[is_free] = factor.solve(prior[is_free] - known)
    return state[0::2].copy(), state[1::2].copy()


def _residual_matrix(submaps: NDArray[np.int64], edges: Sequence[PoseGraphEdge]) -> sparse.csr_matrix:
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


def component_labels(count: int, edges: Sequence[PoseGraphEdge]) -> NDArray[np.int64]:
    """Return the label of the connected component of each submap, shape (count,)."""
    submap_indices = np.array([(edge.first, edge.second) for edge in edges], dtype=np.int64).reshape(-1, 2)
    matrix = sparse.coo_matrix((np.ones(len(submap_indices)), submap_indices.T), shape=(count, count))
    return connected_components(matrix, directed=False)[1].astype(np.int64)


def _factorise(normal: sparse.csc_matrix) -> SuperLU:
    """Factorise a sparse matrix that is Hermitian and positive definite."""
    return splu(normal, permc_spec='MMD_AT_PLUS_A', diag_pivot_thresh=0.0, options={'SymmetricMode': True})
