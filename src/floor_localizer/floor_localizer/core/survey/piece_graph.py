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

_ROUNDS = 4
_MOST_DOTS = 30
# Standard deviation of the scale of a submap, the average over its images.
_SCALE_SIGMA = 0.005


@dataclass(frozen=True)
class Link:
    """Edge of the pose graph: dots shared by two submaps.

    Attributes:
        first: index of the first submap.
        second: index of the second submap.
        in_first: shared dots in the frame of the first submap, complex, shape (k,) [m].
        in_second: the same dots in the frame of the second submap, complex, shape (k,) [m].
        is_loop: whether the edge is a loop closure: the submaps are not consecutive.
    """

    first: int
    second: int
    in_first: NDArray[np.complex128]
    in_second: NDArray[np.complex128]
    is_loop: bool

    def thinned(self) -> Link:
        """Return the edge with at most as many dots as `solve_graph` uses."""
        if len(self.in_first) <= _MOST_DOTS:
            return self
        chosen = np.linspace(0, len(self.in_first) - 1, min(len(self.in_first), _MOST_DOTS)).astype(int)
        return replace(self, in_first=self.in_first[chosen], in_second=self.in_second[chosen])


def solve_graph(
    turns: NDArray[np.complex128],
    shifts: NDArray[np.complex128],
    pieces: NDArray[np.int64],
    links: Sequence[Link],
    free: NDArray[np.bool_],
    sigma: float,
) -> tuple[NDArray[np.complex128], NDArray[np.complex128]]:
    """Return the optimised similarities of submaps.

    Args:
        turns: initial values of a, shape (n,).
        shifts: initial values of b, shape (n,) [m].
        pieces: indices of the submaps, ascending, shape (n,).
        links: edges between them.
        free: whether each submap is optimised, shape (n,); the others are fixed.
        sigma: standard deviation of a shared dot [m].
    """
    A = _differences(pieces, links) / sigma
    state = np.column_stack([turns, shifts]).ravel()
    placed = np.repeat(free, 2)
    weight = np.tile([_SCALE_SIGMA**-2, 1e-6], len(turns))
    normal = (A.conj().T @ A + sparse.diags(weight)).tocsc()
    factor = _factorise(normal[placed][:, placed])
    known = normal[placed][:, ~placed] @ state[~placed]
    for _ in range(_ROUNDS):
        wanted = weight * state
        wanted[0::2] /= np.abs(state[0::2])
        state[placed] = factor.solve(wanted[placed] - known)
    return state[0::2].copy(), state[1::2].copy()


def _differences(pieces: NDArray[np.int64], links: Sequence[Link]) -> sparse.csr_matrix:
    """Return the Jacobian of the differences between shared dots by all a, b."""
    thin = [link.thinned() for link in links]
    counts = [len(link.in_first) for link in thin]
    first, second = (
        np.repeat(2 * np.searchsorted(pieces, ends), counts)
        for ends in ([link.first for link in thin], [link.second for link in thin])
    )
    z, w = (
        np.concatenate(dots) for dots in ([link.in_first for link in thin], [link.in_second for link in thin])
    )
    one = np.ones(len(z))
    rows = np.tile(np.arange(len(z)), 4)
    columns = np.concatenate([first, first + 1, second, second + 1])
    values = np.concatenate([z, one, -w, -one])
    return sparse.csr_matrix((values, (rows, columns)), shape=(len(z), 2 * len(pieces)))


def connected_parts(count: int, links: Sequence[Link]) -> NDArray[np.int64]:
    """Return the label of the connected component of each submap, shape (count,)."""
    ends = np.array([(link.first, link.second) for link in links], dtype=np.int64).reshape(-1, 2)
    matrix = sparse.coo_matrix((np.ones(len(ends)), ends.T), shape=(count, count))
    return connected_components(matrix, directed=False)[1].astype(np.int64)


def _factorise(normal: sparse.csc_matrix) -> SuperLU:
    """Factorise a sparse matrix that is Hermitian and positive definite."""
    return splu(normal, permc_spec='MMD_AT_PLUS_A', diag_pivot_thresh=0.0, options={'SymmetricMode': True})
