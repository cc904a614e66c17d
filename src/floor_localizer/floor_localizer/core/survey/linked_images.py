"""Build the pose graph of the submaps; return the connected images with their initial states."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from floor_localizer.core.dot_map import DotMap
from floor_localizer.core.floor_localizer_error import FloorLocalizerError
from floor_localizer.core.survey.piece import Piece
from floor_localizer.core.survey.piece_graph import connected_parts
from floor_localizer.core.survey.piece_linking import PieceLinker
from floor_localizer.core.survey.shelf import Shelf
from floor_localizer.core.survey.survey_image import SurveyImage
from floor_localizer.core.survey.survey_record import SurveyRecord
from floor_localizer.core.survey.survey_settings import SurveySettings

_LEAST_PART = 0.5
"""Smallest fraction of the images that must be connected."""


@dataclass(frozen=True)
class LinkedImages:
    """Images that are connected by the pose graph.

    Attributes:
        images: indices of the images, shape (k,).
        states: x, y [m], yaw [rad], scale, roll, pitch [rad] of each, shape (k, 6).
        loops: number of loop closures.
    """

    images: NDArray[np.int64]
    states: NDArray[np.float64]
    loops: int


def link_images(
    images: Sequence[SurveyImage],
    pieces: Iterable[Piece],
    settings: SurveySettings,
    shelf: Shelf,
    existing: DotMap | None,
    record: SurveyRecord,
) -> LinkedImages:
    """Build and optimise the pose graph, unless the checkpoint has it; return the images of its main component.

    Args:
        images: all images of the survey.
        pieces: submaps of the images, in order.
        settings: survey settings.
        shelf: array store of the submaps' dots.
        existing: map to extend, None for a new one.
        record: checkpoint of this step.

    Raises:
        FloorLocalizerError: the images do not overlap.
    """
    known = record.recall('linked')
    if known is not None:
        return LinkedImages(known['images'], known['states'], int(known['loops']))
    linker = PieceLinker(images, settings, None if existing is None else existing.points, shelf)
    for piece in pieces:
        linker.add(piece)
    linker.places.settle()
    turns, shifts = linker.places.arrays()
    chosen = _main_part(linker, 0 if existing is None else 1, images)
    used, states = _global_states([linker.pieces[k] for k in chosen], turns[chosen], shifts[chosen])
    loops = sum(link.is_loop for link in linker.places.links)
    record.keep('linked', images=used, states=states, loops=np.array(loops))
    return LinkedImages(used, states, loops)


def _main_part(linker: PieceLinker, first: int, images: Sequence[SurveyImage]) -> NDArray[np.int64]:
    """Return the submaps that are connected to the existing map, or those of the largest component."""
    pieces = linker.pieces
    parts = connected_parts(len(pieces), linker.places.links)
    sizes = np.array([len(piece.images) for piece in pieces])
    main = parts[0] if first else int(np.argmax(np.bincount(parts, sizes)))
    chosen = first + np.flatnonzero(parts[first:] == main)
    share = sizes[chosen].sum() / sizes.sum()
    if len(chosen) == 0:
        raise FloorLocalizerError(
            'the images show nothing of the map that is to be extended; begin the drive on floor that is in it'
        )
    if share < _LEAST_PART:
        torn = next(pieces[k] for k in range(first + 1, len(pieces)) if parts[k] != parts[k - 1])
        raise FloorLocalizerError(
            f'no overlap: only {share:.0%} of the images are connected, '
            f'{images[torn.images[0]].name} matches none before it; drive slower or in narrower lanes, '
            'and check camera_xyz, camera_rpy and the odometry'
        )
    return chosen


def _global_states(
    pieces: Sequence[Piece], turns: NDArray[np.complex128], shifts: NDArray[np.complex128]
) -> tuple[NDArray[np.int64], NDArray[np.float64]]:
    """Return the images of submaps, each once, and their states on the map."""
    used: dict[int, NDArray[np.float64]] = {}
    for piece, a, b in zip(pieces, turns, shifts, strict=True):
        places = a * (piece.states[:, :2] @ (1.0, 1j)) + b
        for index, place, state in zip(piece.images.tolist(), places, piece.states, strict=True):
            moved = state.copy()
            moved[:3] = place.real, place.imag, state[2] + np.angle(a)
            moved[3] = (1.0 + state[3]) * abs(a) - 1.0
            used.setdefault(index, moved)
    order = np.array(sorted(used), dtype=np.int64)
    return order, np.array([used[index] for index in order.tolist()])
