"""Where all pieces lie: similarities a z + b of the plane whose links agree best.

A link between two pieces is a set of dots they share, z in one and w in the other, and asks for

    a_i z + b_i = a_j w + b_j,

which is linear in the complex a and b. The magnitude of a, the piece's scale, stays near 1: w |a - a/|a||^2 is added
and renewed. One piece, or the dots of a map that is extended, is fixed.
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
# A piece may be larger or smaller by about this share: the scales of its images, averaged.
_SCALE_SIGMA = 0.005


@dataclass(frozen=True)
class Link:
    """Dots that two pieces share.

    Attributes:
        first: index of a piece.
        second: index of another one.
        in_first: shape (k,) complex, the dots in the first piece [m].
        in_second: shape (k,) complex, the same dots in the second one [m].
        is_loop: whether the pieces do not follow each other.
    """

    first: int
    second: int
    in_first: NDArray[np.complex128]
    in_second: NDArray[np.complex128]
    is_loop: bool

    def thinned(self) -> Link:
        """Return the link with no more dots than `solve_graph` takes."""
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
    """Return the similarities of pieces.

    Args:
        turns: shape (n,), start of a.
        shifts: shape (n,), start of b [m].
        pieces: shape (n,), their indices, rising.
        links: between them.
        free: shape (n,), which of them are placed; the others stay.
        sigma: of a shared dot [m].
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
    """Return the matrix that takes all a, b to how far each shared dot is apart in the pieces that share it."""
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
    """Return the number of the part that each piece belongs to, shape (count,)."""
    ends = np.array([(link.first, link.second) for link in links], dtype=np.int64).reshape(-1, 2)
    matrix = sparse.coo_matrix((np.ones(len(ends)), ends.T), shape=(count, count))
    return connected_components(matrix, directed=False)[1].astype(np.int64)


def _factorise(normal: sparse.csc_matrix) -> SuperLU:
    """Return the factors of a sparse matrix that is Hermitian and positive definite."""
    return splu(normal, permc_spec='MMD_AT_PLUS_A', diag_pivot_thresh=0.0, options={'SymmetricMode': True})
