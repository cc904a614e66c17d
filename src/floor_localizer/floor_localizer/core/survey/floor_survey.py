"""From pieces to one map: place them, adjust all images and dots at once, drop dirt."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from floor_localizer.core.dot_map import DotMap
from floor_localizer.core.floor_localizer_error import FloorLocalizerError
from floor_localizer.core.survey.adjustment import BodyPriors, adjust_blocks, place_dots, without_outliers
from floor_localizer.core.survey.block_cutting import BlockCutter
from floor_localizer.core.survey.fixed_dots import fix_dots
from floor_localizer.core.survey.piece import Piece
from floor_localizer.core.survey.piece_graph import connected_parts
from floor_localizer.core.survey.piece_linking import PieceLinker
from floor_localizer.core.survey.shelf import Shelf
from floor_localizer.core.survey.sighting_blocks import SightingBlocks
from floor_localizer.core.survey.survey_image import ImageSelection, SurveyImage, ViewOutline
from floor_localizer.core.survey.survey_settings import SurveySettings
from floor_localizer.core.survey.surveyed_dots import Residuals, gather_dots

# Pieces lie right to about this many times what makes two sightings one dot, adjusted ones to less.
_REACHES = (1.6, 1.0, 0.8)
_OUTLIER = 8.0
# No robot is taken for stiffer than this: share of its height, and tilt [rad].
_STIFFEST = 3e-5
_LEAST_PART = 0.5
"""Of the images that are linked to each other, at least."""

Progress = Callable[[str], None]


@dataclass(frozen=True)
class SurveyResult:
    """A surveyed floor.

    Attributes:
        dot_map: the dots; those of the map that was extended come first, as they were.
        counts: shape (n,), how many images saw each dot; 0 for dots of the old map that none saw.
        images: indices of the images that were used.
        states: shape (k, 6), of these: x, y [m], yaw [rad], scale, roll, pitch [rad].
        blocks: the sightings; their images are indices of ``images``.
        residuals: of the sightings, block by block.
        loops: number of links between pieces that do not follow each other.
        dirt: number of dots that were dropped.
        left_out: indices of images that are linked to no others.
        old_dots: number of dots of the map that was extended.
    """

    dot_map: DotMap
    counts: NDArray[np.int64]
    images: NDArray[np.int64]
    states: NDArray[np.float64]
    blocks: SightingBlocks
    residuals: Residuals
    loops: int
    dirt: int
    left_out: NDArray[np.int64]
    old_dots: int


def survey_floor(
    images: Sequence[SurveyImage],
    pieces: Iterable[Piece],
    outline: ViewOutline,
    position: NDArray[np.float64],
    settings: SurveySettings,
    shelf: Shelf,
    existing: DotMap | None = None,
    progress: Progress = lambda _: None,
) -> SurveyResult:
    """Make one map.

    Args:
        images: all images of the survey.
        pieces: into which they were put together, in their order.
        outline: what an image shows.
        position: of the optical centre in the base frame [m].
        settings: of the survey.
        shelf: for what does not fit into memory; the result needs it further on.
        existing: a map that is extended; its dots stay where they are.
        progress: is told each step.

    Raises:
        FloorLocalizerError: the images do not overlap.
    """
    old = None if existing is None else existing.points
    used, states, loops = _linked(images, pieces, settings, shelf, old, progress)
    cutter = BlockCutter(ImageSelection(images, used), position, settings.dot_sigma, shelf)
    priors = BodyPriors(position, settings.scale_sigma, settings.tilt_sigma)
    for reach in _REACHES:
        progress('adjusting')
        blocks = cutter.cut(states, reach * settings.same_dot)
        if old is not None:
            fix_dots(blocks, states, position, old, reach * settings.same_dot)
        states = adjust_blocks(blocks, states, priors, shelf)
        _drop_outliers(blocks, states, position)
        states = adjust_blocks(blocks, states, priors, shelf)
        priors = learned_priors(states, position, settings)
    dots = gather_dots(blocks, states, position, outline, existing, shelf)
    return SurveyResult(
        dots.dot_map, dots.counts, used, states, blocks, Residuals(shelf, blocks),
        loops, dots.dirt, np.setdiff1d(np.arange(len(images)), used), dots.old_dots,
    )  # fmt: skip


def _linked(
    images: Sequence[SurveyImage],
    pieces: Iterable[Piece],
    settings: SurveySettings,
    shelf: Shelf,
    old: NDArray[np.float64] | None,
    progress: Progress,
) -> tuple[NDArray[np.int64], NDArray[np.float64], int]:
    """Place the pieces; return the images of those that are linked, their states, and the number of loops."""
    linker = PieceLinker(images, settings, old, shelf)
    for piece in pieces:
        linker.add(piece)
        progress('placing pieces')
    turns, shifts = linker.solve()
    chosen = _main_part(linker, 0 if old is None else 1, images)
    used, states = _global_states([linker.pieces[k] for k in chosen], turns[chosen], shifts[chosen])
    return used, states, sum(link.is_loop for link in linker.links)


def _drop_outliers(
    blocks: SightingBlocks, states: NDArray[np.float64], position: NDArray[np.float64]
) -> None:
    for number, block in enumerate(blocks):
        _, residuals = place_dots(block, states, position)
        blocks.put(number, without_outliers(block, residuals, _OUTLIER))


def learned_priors(
    states: NDArray[np.float64], position: NDArray[np.float64], settings: SurveySettings
) -> BodyPriors:
    """Return priors as wide as the robot was found to sway, at most as wide as the settings allow.

    Heights and tilts that a stiff robot might have had, but did not, would bend the map: a hundred images in a row can
    share a tilt that no single one of them tells from none.

    Args:
        states: shape (k, 6), of all images.
        position: of the optical centre in the base frame [m].
        settings: of the survey.
    """
    scale, roll, pitch = np.sqrt(np.mean(states[:, 3:] ** 2, axis=0))
    tilt = np.hypot(roll, pitch) / np.sqrt(2.0)
    return BodyPriors(
        position,
        float(np.clip(scale, _STIFFEST, settings.scale_sigma)),
        float(np.clip(tilt, _STIFFEST, settings.tilt_sigma)),
    )


def _main_part(linker: PieceLinker, first: int, images: Sequence[SurveyImage]) -> NDArray[np.int64]:
    """Return the linker's numbers of the pieces that are linked to the old map, or else to most others."""
    pieces = linker.pieces
    parts = connected_parts(len(pieces), linker.links)
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
            f'no overlap: only {share:.0%} of the images are linked to each other, {images[torn.images[0]].name} '
            'fits none before it; drive slower or in narrower lanes, and check camera_xyz, camera_rpy and the odometry'
        )
    return chosen


def _global_states(
    pieces: Sequence[Piece], turns: NDArray[np.complex128], shifts: NDArray[np.complex128]
) -> tuple[NDArray[np.int64], NDArray[np.float64]]:
    """Return the images of pieces, each once, and their states on the map."""
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
