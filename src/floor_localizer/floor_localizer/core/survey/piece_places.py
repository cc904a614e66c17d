"""Incremental optimisation of the pose graph while submaps are added.

A new submap is aligned to its edges. If a small residual is left, a sliding window of the last submaps is optimised.
The whole graph is optimised if that is not enough, if the residual of a loop closure is large, and whenever the number
of submaps has grown by a fraction, so that the total work is linear in their number.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from floor_localizer.core.survey.piece_graph import Link, solve_graph

DOT_SIGMA = 0.0002
"""Standard deviation of a dot in a submap, which may be slightly bent [m]."""
_TORN, _FAR = 0.001, 0.005
"""Residual of an edge above which the window, and above which the whole graph is optimised [m]."""
_SETTLE_EVERY, _SETTLE_SHARE = 8, 0.1
_LAST = 64
"""Number of submaps in the sliding window."""


class PiecePlaces:
    """Similarities a z + b of the submaps in the map frame.

    Attributes:
        turns: complex rotation and scale a of each submap.
        shifts: complex translation b of each submap [m].
        links: edges between the submaps.
    """

    def __init__(self) -> None:
        """Begin without a submap."""
        self.turns: list[complex] = []
        self.shifts: list[complex] = []
        self.links: list[Link] = []
        self._links_of: list[list[Link]] = []
        self._since_settled = 0

    def append(self, turn: complex, shift: complex) -> None:
        """Add a submap."""
        self.turns.append(turn)
        self.shifts.append(shift)
        self._links_of.append([])

    def add_edges(self, links: Sequence[Link]) -> None:
        """Add edges of the last submap, align it to them, and optimise the graph if a residual is left."""
        if not links:
            return
        thin = [link.thinned() for link in links]
        self.links += thin
        self._links_of[-1] += thin
        self._since_settled += 1
        count = len(self.turns)
        tear = self.place(links)
        if _TORN < tear < _FAR:
            self._settle(max(count - _LAST, 1))
            tear = self._tear(links)
        if tear > _TORN or self._since_settled >= max(_SETTLE_EVERY, _SETTLE_SHARE * count):
            self.settle()

    def place(self, links: Sequence[Link]) -> float:
        """Align the second submap of some edges to them; return the largest remaining residual [m]."""
        mine = np.concatenate([link.in_second for link in links])
        theirs = np.concatenate(
            [self.turns[link.first] * link.in_first + self.shifts[link.first] for link in links]
        )
        off = mine - mine.mean()
        turn = np.vdot(off, theirs - theirs.mean())
        turn /= abs(turn)
        index, shift = links[0].second, theirs.mean() - turn * mine.mean()
        self.turns[index], self.shifts[index] = complex(turn), complex(shift)
        return self._tear(links)

    def settle(self) -> None:
        """Optimise all submaps but the first."""
        self._since_settled = 0
        self._settle(1)

    def arrays(self) -> tuple[NDArray[np.complex128], NDArray[np.complex128]]:
        """Return the similarities, shape (n,) each."""
        return np.array(self.turns), np.array(self.shifts)

    def _settle(self, begin: int) -> None:
        """Optimise the submaps from one on; the others are fixed."""
        links = [link for several in self._links_of[begin:] for link in several]
        if not links:
            return
        pieces = np.unique([(link.first, link.second) for link in links])
        turns, shifts = (np.array(each)[pieces] for each in (self.turns, self.shifts))
        turns, shifts = solve_graph(turns, shifts, pieces, links, pieces >= begin, DOT_SIGMA)
        for piece, turn, shift in zip(pieces.tolist(), turns.tolist(), shifts.tolist(), strict=True):
            self.turns[piece], self.shifts[piece] = turn, shift

    def _tear(self, links: Sequence[Link]) -> float:
        return max(
            float(np.abs(
                self.turns[link.first] * link.in_first + self.shifts[link.first]
                - self.turns[link.second] * link.in_second - self.shifts[link.second]
            ).max())
            for link in links
        )  # fmt: skip
