"""Which pieces share dots: those that follow each other, those that lie side by side, and loops that close.

Piece after piece is placed by the odometry of its first image and laid on the pieces that may lie there; where it may
be anywhere by now, it is looked for on all the dots so far by constellations. What could be chance is no link.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from floor_localizer.core.survey.dot_matching import DotField, Matched, Tolerances, nearest_pairs
from floor_localizer.core.survey.piece import Piece, overlapping
from floor_localizer.core.survey.piece_fields import PieceFields
from floor_localizer.core.survey.piece_graph import Link
from floor_localizer.core.survey.piece_places import DOT_SIGMA, PiecePlaces
from floor_localizer.core.survey.shelf import Shelf
from floor_localizer.core.survey.survey_image import SurveyImage
from floor_localizer.core.survey.survey_settings import SurveySettings
from shirube_geometry import PlanarPose

_SCALE = 0.02
_LEAST_SHARED = 6
# The chain of images drifts by this share of the way, odometry by another; the search area ends at the widest [m, rad].
_DRIFT, _ODOMETRY_DRIFT, _WIDEST, _WIDEST_TURN = 0.02, 0.1, 0.12, 0.4
# A heading is as certain as this, and so many times less certain a metre of drift [rad, 1/m].
_TURN, _TURN_BY_DRIFT = 0.02, 20.0
# How far a piece is from where an image puts it that another one has, too, and from where a link does [m].
_BY_IMAGE, _BY_LINK = 0.003, 0.004
# Dots are shared that are nearer to each other than so many standard deviations.
_SHARED = 5.0
# Of a piece that is laid on another one, those dots count that may have dots of it within so many cells.
_CELLS_AROUND = 2.5
_SURELY = 1e-3
"""A link from anywhere must be surer by this."""


class PieceLinker:
    """Places pieces one after the other.

    Attributes:
        pieces: those so far without their dots, which are on the shelf.
        places: where each lies, and the links between them.
    """

    def __init__(
        self,
        images: Sequence[SurveyImage],
        settings: SurveySettings,
        existing: NDArray[np.float64] | None,
        shelf: Shelf,
    ) -> None:
        """Begin.

        Args:
            images: of the survey.
            settings: of the survey.
            existing: shape (n, 2), dots of a map that is extended [m]; it becomes piece 0, without images.
            shelf: for the dots.
        """
        self._images, self._settings = images, settings
        self.pieces: list[Piece] = []
        self.places = PiecePlaces()
        self._fields = PieceFields(shelf)
        self._drift: list[float] = []
        self._all_dots: tuple[int, DotField, NDArray[np.int64]] | None = None
        if existing is not None:
            old = Piece(
                np.empty(0, dtype=np.int64), np.empty((0, 6)), existing, np.empty(0, dtype=np.int64), False
            )
            self._append(old, 1.0 + 0.0j, 0.0j, 0.0)

    def add(self, piece: Piece) -> None:
        """Place the next piece."""
        index = len(self.pieces)
        turn, shift, drift = self._expected(piece)
        self._append(piece, turn, shift, drift)
        if index == 0:
            return
        new = [*self._chain_link(index), *self._links_beside(index)]
        if not any(link.is_loop for link in new) and (drift >= _WIDEST or not new):
            new += self._links_anywhere(index)
        if any(link.is_loop for link in new):
            self._drift[index] = 0.0
        self.places.link(new)

    def _append(self, piece: Piece, turn: complex, shift: complex, drift: float) -> None:
        self._fields.append(piece.dots)
        self.pieces.append(replace(piece, dots=piece.dots[:0].copy(), counts=piece.counts[:0].copy()))
        self._drift.append(drift)
        self.places.append(turn, shift)

    def _expected(self, piece: Piece) -> tuple[complex, complex, float]:
        """Return where a piece is expected by the one before, and how far it may be off [m]."""
        if not self.pieces or len(self.pieces[-1].images) == 0:
            # On a map that is extended it may be anywhere.
            return 1.0 + 0.0j, 0.0j, _WIDEST if self.pieces else 0.0
        before = self.pieces[-1]
        last = before.images[-1]
        x, y, yaw = (float(value) for value in before.states[-1, :3])
        step = self._images[last].T_odom_base.inverse() @ self._images[piece.images[0]].T_odom_base
        pose = PlanarPose(x, y, yaw) @ step
        a = self.places.turns[-1] / abs(self.places.turns[-1])
        turn = a * complex(np.exp(1j * pose.yaw))
        shift = self.places.turns[-1] * complex(pose.x, pose.y) + self.places.shifts[-1]
        drift = self._drift[-1] + _DRIFT * float(np.sum(np.hypot(*np.diff(before.states[:, :2], axis=0).T)))
        if not piece.is_linked:
            jump = self._settings.odometry_radius + float(np.hypot(step.x, step.y)) * _ODOMETRY_DRIFT
            drift += jump
        return turn, shift, drift

    def _pose(self, index: int) -> PlanarPose:
        return PlanarPose(
            self.places.shifts[index].real,
            self.places.shifts[index].imag,
            float(np.angle(self.places.turns[index])),
        )

    def _chain_link(self, index: int) -> Iterator[Link]:
        """Link a piece to the one before by the dots of the image that both have."""
        if not self.pieces[index].is_linked or len(self.pieces[index - 1].images) == 0:
            return
        found = self._lay(index, index - 1, _BY_IMAGE, _TURN)
        if found is not None:
            yield self._link(index, index - 1, found, is_loop=False)

    def _links_beside(self, index: int) -> Iterator[Link]:
        """Link a piece to those that may lie where it is expected."""
        radius = min(self._drift[index] + _BY_IMAGE, _WIDEST)
        turn = min(_TURN * (1.0 + _TURN_BY_DRIFT * self._drift[index]), _WIDEST_TURN)
        before = index - 1 if self.pieces[index].is_linked else index
        while True:
            for other in self._candidates(index, before, radius):
                found = self._lay(index, other, radius, turn)
                if found is not None:
                    link = self._link(index, other, found, is_loop=True)
                    yield link
                    # The first link tells where the piece lies; the others must lie there, too.
                    self.places.place([link])
                    before, radius, turn = other, _BY_LINK, _TURN
                    break
            else:
                return

    def _candidates(self, index: int, before: int, radius: float) -> Iterator[int]:
        """Yield the pieces below ``before`` that a piece may overlap, the latest first."""
        turns, shifts = self.places.arrays()
        near = self._fields.near(index, turns / np.abs(turns), shifts, radius)
        for other in near[near < before][::-1].tolist():
            pose = self._pose(other).inverse() @ self._pose(index)
            if self._fields.may_overlap(index, other, pose, radius):
                yield other

    def _lay(self, index: int, other: int, radius: float, turn: float) -> Matched | None:
        """Lay a piece on another where it is expected."""
        field = self._fields[other]
        expected = self._pose(other).inverse() @ self._pose(index)
        reach = _CELLS_AROUND * field.grid.cell + radius
        points = overlapping(self._fields[index].points, field.points, expected, reach)
        if len(points) == 0:
            return None
        # About their own middle, for what is far from the origin swings far.
        middle = points.mean(axis=0)
        x, y = (float(value) for value in expected.transform([middle])[0])
        about = PlanarPose(x, y, expected.yaw)
        by = Tolerances(DOT_SIGMA, _SCALE, 0.0, self._settings.chance)
        return self._shared(index, other, field.match_near(points - middle, about, radius, turn, by), middle)

    def _shared(
        self, index: int, other: int, found: Matched | None, middle: NDArray[np.float64]
    ) -> Matched | None:
        """Return all dots that the pieces share under a match of some; None where these are too few."""
        if found is None:
            return None
        z = (self._fields[index].points - middle) @ (1.0, 1j)
        placed = found.turn * z + found.shift
        laid, under = nearest_pairs(
            self._fields[other].points, np.column_stack([placed.real, placed.imag]), _SHARED * DOT_SIGMA
        )
        if len(laid) < _LEAST_SHARED:
            return None
        return replace(_about_origin(found, middle), laid=laid, under=under)

    def _link(self, index: int, other: int, found: Matched, *, is_loop: bool) -> Link:
        mine, theirs = self._fields[index].points[found.laid], self._fields[other].points[found.under]
        return Link(other, index, _complex(theirs), _complex(mine), is_loop)

    def _links_anywhere(self, index: int) -> list[Link]:
        """Look a piece up among the dots of all earlier pieces."""
        others = self._earlier_dots(index)
        if others is None:
            return []
        field, owners = others
        points = self._fields[index].points
        by = Tolerances(DOT_SIGMA, _SCALE, 0.0, _SURELY * self._settings.chance)
        middle = points.mean(axis=0)
        found = field.match_anywhere(points - middle, by)
        if found is None:
            return []
        found = _about_origin(found, middle)
        links = []
        self.places.turns[index], self.places.shifts[index] = found.turn / abs(found.turn), found.shift
        for other in np.unique(owners[found.under]):
            laid = self._lay(index, int(other), _BY_LINK, _TURN)
            if laid is not None:
                links.append(self._link(index, int(other), laid, is_loop=True))
        return links

    def _earlier_dots(self, index: int) -> tuple[DotField, NDArray[np.int64]] | None:
        """Return the dots of pieces well before, and which piece each is of; renewed now and then."""
        until = index - 3 if len(self.pieces[0].images) else index
        if until < 1:
            return None
        if self._all_dots is None or until - self._all_dots[0] > 20 + until // 4:
            self._all_dots = None  # before there are others: never two of them in memory
            parts, owners = [], []
            for k in range(until):
                z = self.places.turns[k] * (self._fields.dots(k) @ (1.0, 1j)) + self.places.shifts[k]
                parts.append(np.column_stack([z.real, z.imag]))
                owners.append(np.full(len(z), k))
            self._all_dots = (until, DotField(np.concatenate(parts)), np.concatenate(owners))
        return self._all_dots[1], self._all_dots[2]


def _about_origin(found: Matched, middle: NDArray[np.float64]) -> Matched:
    """Return a match of dots about their middle, shape (2,) [m], as one about the origin."""
    return replace(found, shift=found.shift - found.turn * complex(*middle))


def _complex(points: NDArray[np.float64]) -> NDArray[np.complex128]:
    return points[:, 0] + 1j * points[:, 1]
