"""Build the pose graph: edges between consecutive submaps, neighbouring lanes, and loop closures.

Each new submap is placed by the odometry of its first image and registered to the submaps it may overlap. If the drift
since the last loop closure is too large, it is searched in all earlier dots by constellations. Matches that may be
chance are rejected.
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
# Drift of the image chain and of odometry per distance driven; largest search radius [m] and yaw tolerance [rad].
_DRIFT, _ODOMETRY_DRIFT, _WIDEST, _WIDEST_TURN = 0.02, 0.1, 0.12, 0.4
# Yaw tolerance without drift [rad], and its relative growth per metre of drift [1/m].
_TURN, _TURN_BY_DRIFT = 0.02, 20.0
# Search radius if the position is known from a shared image, and from another edge [m].
_BY_IMAGE, _BY_LINK = 0.003, 0.004
# Two submaps share the dots that are within this many standard deviations.
_SHARED = 5.0
# Margin of the possible overlap of two submaps, in grid cells.
_CELLS_AROUND = 2.5
_SURELY = 1e-3
"""A global match must be less likely by chance by this factor."""


class PieceLinker:
    """Adds submaps to the pose graph one after the other.

    Attributes:
        pieces: submaps so far, without their dots, which are in the array store.
        places: poses of the submaps, and the edges between them.
    """

    def __init__(
        self,
        images: Sequence[SurveyImage],
        settings: SurveySettings,
        existing: NDArray[np.float64] | None,
        shelf: Shelf,
    ) -> None:
        """Begin with an empty graph, or with the existing map as submap 0.

        Args:
            images: all images of the survey.
            settings: survey settings.
            existing: dots of the map to extend, shape (n, 2) [m]; they become submap 0, without images.
            shelf: array store of the dots.
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
        """Add the next submap and its edges."""
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
        self.places.add_edges(new)

    def _append(self, piece: Piece, turn: complex, shift: complex, drift: float) -> None:
        self._fields.append(piece.dots)
        self.pieces.append(replace(piece, dots=piece.dots[:0].copy(), counts=piece.counts[:0].copy()))
        self._drift.append(drift)
        self.places.append(turn, shift)

    def _expected(self, piece: Piece) -> tuple[complex, complex, float]:
        """Return the pose of a submap predicted from the previous one, and its drift [m]."""
        if not self.pieces or len(self.pieces[-1].images) == 0:
            # The first submap may be anywhere on the map to extend.
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
        """Yield the edge to the previous submap, from the dots of the image that both contain."""
        if not self.pieces[index].is_linked or len(self.pieces[index - 1].images) == 0:
            return
        found = self._lay(index, index - 1, _BY_IMAGE, _TURN)
        if found is not None:
            yield self._link(index, index - 1, found, is_loop=False)

    def _links_beside(self, index: int) -> Iterator[Link]:
        """Yield loop closures to the submaps around the predicted pose."""
        radius = min(self._drift[index] + _BY_IMAGE, _WIDEST)
        yaw_tolerance = min(_TURN * (1.0 + _TURN_BY_DRIFT * self._drift[index]), _WIDEST_TURN)
        before = index - 1 if self.pieces[index].is_linked else index
        while True:
            for other in self._candidates(index, before, radius):
                found = self._lay(index, other, radius, yaw_tolerance)
                if found is not None:
                    link = self._link(index, other, found, is_loop=True)
                    yield link
                    # The first edge fixes the pose of the submap; the others must agree with it.
                    self.places.place([link])
                    before, radius, yaw_tolerance = other, _BY_LINK, _TURN
                    break
            else:
                return

    def _candidates(self, index: int, before: int, radius: float) -> Iterator[int]:
        """Yield the submaps before number ``before`` that a submap may overlap, the latest first."""
        turns, shifts = self.places.arrays()
        near = self._fields.overlap_candidates(index, turns / np.abs(turns), shifts, radius)
        for other in near[near < before][::-1].tolist():
            pose = self._pose(other).inverse() @ self._pose(index)
            if self._fields.may_overlap(index, other, pose, radius):
                yield other

    def _lay(self, index: int, other: int, radius: float, yaw_tolerance: float) -> Matched | None:
        """Register a submap to another one near its predicted pose; None if they do not match."""
        field = self._fields[other]
        expected = self._pose(other).inverse() @ self._pose(index)
        reach = _CELLS_AROUND * field.grid.cell + radius
        points = overlapping(self._fields[index].points, field.points, expected, reach)
        if len(points) == 0:
            return None
        # Relative to their centroid: far from the origin, a small rotation moves dots far.
        middle = points.mean(axis=0)
        x, y = (float(value) for value in expected.transform([middle])[0])
        about = PlanarPose(x, y, expected.yaw)
        by = Tolerances(DOT_SIGMA, _SCALE, 0.0, self._settings.chance)
        return self._shared(
            index, other, field.match_near(points - middle, about, radius, yaw_tolerance, by), middle
        )

    def _shared(
        self, index: int, other: int, found: Matched | None, middle: NDArray[np.float64]
    ) -> Matched | None:
        """Return all dots that two submaps share, given a match of some; None if they are too few."""
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
        """Search a submap among the dots of all earlier submaps; return the loop closures found."""
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
        """Return the dots of earlier submaps and the submap of each; cached and rebuilt as the map grows."""
        until = index - 3 if len(self.pieces[0].images) else index
        if until < 1:
            return None
        if self._all_dots is None or until - self._all_dots[0] > 20 + until // 4:
            self._all_dots = None  # release it first: never two of them in memory
            parts, owners = [], []
            for k in range(until):
                z = self.places.turns[k] * (self._fields.dots(k) @ (1.0, 1j)) + self.places.shifts[k]
                parts.append(np.column_stack([z.real, z.imag]))
                owners.append(np.full(len(z), k))
            self._all_dots = (until, DotField(np.concatenate(parts)), np.concatenate(owners))
        return self._all_dots[1], self._all_dots[2]


def _about_origin(found: Matched, middle: NDArray[np.float64]) -> Matched:
    """Return a match of dots relative to their centroid, shape (2,) [m], as one relative to the origin."""
    return replace(found, shift=found.shift - found.turn * complex(*middle))


def _complex(points: NDArray[np.float64]) -> NDArray[np.complex128]:
    return points[:, 0] + 1j * points[:, 1]
