"""Where the pieces lie while they are linked: each where its links want it, all settled anew where these disagree.

What is torn a little is settled among the pieces that came last. All are settled where that does not help, where a
loop closes that was far off, and whenever there are a share more of them: so the work grows with their number.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from floor_localizer.core.survey.piece_graph import Link, solve_graph

DOT_SIGMA = 0.0002
"""Of a dot in a piece: pieces bend a little [m]."""
_TORN, _FAR = 0.001, 0.005
"""A link that is torn by more than this makes pieces be placed anew; by more than that, all of them [m]."""
_SETTLE_EVERY, _SETTLE_SHARE = 8, 0.1
_LAST = 64
"""Pieces that are settled by themselves."""


class PiecePlaces:
    """Similarities a z + b of the pieces.

    Attributes:
        turns: a of each.
        shifts: b of each [m].
        links: between them.
    """

    def __init__(self) -> None:
        """Begin without a piece."""
        self.turns: list[complex] = []
        self.shifts: list[complex] = []
        self.links: list[Link] = []
        self._links_of: list[list[Link]] = []
        self._since_settled = 0

    def append(self, turn: complex, shift: complex) -> None:
        """Add a piece."""
        self.turns.append(turn)
        self.shifts.append(shift)
        self._links_of.append([])

    def link(self, links: Sequence[Link]) -> None:
        """Link the last piece to others, place it where the links want it, and settle pieces if they disagree."""
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
        """Place the piece that links are of where they want it; return how far they are torn then [m]."""
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
        """Place all pieces but the first where all links agree best."""
        self._since_settled = 0
        self._settle(1)

    def arrays(self) -> tuple[NDArray[np.complex128], NDArray[np.complex128]]:
        """Return the similarities, shape (n,) each."""
        return np.array(self.turns), np.array(self.shifts)

    def _settle(self, begin: int) -> None:
        """Settle the pieces from one on, as the others lie."""
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
