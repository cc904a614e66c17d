"""From pieces to one map: place them, adjust all images and dots at once, drop dirt."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.spatial import cKDTree

from floor_localizer.core.dot_map import DotMap
from floor_localizer.core.floor_localizer_error import FloorLocalizerError
from floor_localizer.core.survey.adjustment import Adjusted, BodyPriors, Sightings, adjust, without_outliers
from floor_localizer.core.survey.dot_matching import nearest_pairs
from floor_localizer.core.survey.piece import Piece, join_sightings
from floor_localizer.core.survey.piece_graph import connected_parts
from floor_localizer.core.survey.piece_linking import PieceLinker
from floor_localizer.core.survey.sightings import count_views
from floor_localizer.core.survey.survey_image import SurveyImage, ViewOutline
from floor_localizer.core.survey.survey_settings import SurveySettings

# Pieces lie right to about this many times what makes two sightings one dot, adjusted ones to less.
_REACHES = (1.6, 1.0, 0.8)
_OUTLIER = 8.0
# No robot is taken for stiffer than this: share of its height, and tilt [rad].
_STIFFEST = 3e-5
_SEVERAL = 2
"""A dot that was seen once though so many images should have seen it is dirt."""
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
        sightings: image (in ``images``) and dot of each sighting.
        residuals: shape (s, 2), of the sightings [m].
        loops: number of links between pieces that do not follow each other.
        dirt: number of dots that were dropped.
        left_out: indices of images that are linked to no others.
        old_dots: number of dots of the map that was extended.
    """

    dot_map: DotMap
    counts: NDArray[np.int64]
    images: NDArray[np.int64]
    states: NDArray[np.float64]
    sightings: Sightings
    residuals: NDArray[np.float64]
    loops: int
    dirt: int
    left_out: NDArray[np.int64]
    old_dots: int


def survey_floor(
    images: Sequence[SurveyImage],
    pieces: Sequence[Piece],
    outline: ViewOutline,
    position: NDArray[np.float64],
    settings: SurveySettings,
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
        existing: a map that is extended; its dots stay where they are.
        progress: is told each step.

    Raises:
        FloorLocalizerError: the images do not overlap.
    """
    old = None if existing is None else existing.points
    linker = PieceLinker(images, settings, old)
    for piece in pieces:
        linker.add(piece)
        progress('placing pieces')
    turns, shifts = linker.solve()
    first = 0 if existing is None else 1
    chosen = _main_part(pieces, linker, first, images)
    used, states = _global_states([pieces[k] for k in chosen], turns[chosen + first], shifts[chosen + first])
    priors = BodyPriors(position, settings.scale_sigma, settings.tilt_sigma)
    picked = [images[k] for k in used]
    for reach in _REACHES:
        progress('adjusting')
        sightings, count = join_sightings(
            picked, states, position, reach * settings.same_dot, settings.dot_sigma
        )
        fixed = _fixed_dots(sightings, states, position, count, old, reach * settings.same_dot)
        adjusted = adjust(sightings, states, fixed, priors)
        sightings = without_outliers(sightings, adjusted.residuals, _OUTLIER)
        adjusted = adjust(sightings, adjusted.states, fixed, priors)
        states = adjusted.states
        priors = learned_priors(states, position, settings)
    left_out = np.setdiff1d(np.arange(len(images)), used)
    loops = sum(link.is_loop for link in linker.links)
    return _result(picked, used, sightings, adjusted, fixed, outline, existing, loops, left_out)


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


def _main_part(
    pieces: Sequence[Piece], linker: PieceLinker, first: int, images: Sequence[SurveyImage]
) -> NDArray[np.int64]:
    """Return the pieces that are linked to the old map, or else to most others."""
    parts = connected_parts(len(pieces) + first, linker.links)
    sizes = np.array([len(piece.images) for piece in pieces])
    main = parts[0] if first else int(np.argmax(np.bincount(parts, sizes)))
    chosen = np.flatnonzero(parts[first:] == main)
    share = sizes[chosen].sum() / sizes.sum()
    if len(chosen) == 0:
        raise FloorLocalizerError(
            'the images show nothing of the map that is to be extended; begin the drive on floor that is in it'
        )
    if share < _LEAST_PART:
        torn = next(
            piece for k, piece in enumerate(pieces[1:], 1) if parts[first + k] != parts[first + k - 1]
        )
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


def _fixed_dots(
    sightings: Sightings,
    states: NDArray[np.float64],
    position: NDArray[np.float64],
    count: int,
    old: NDArray[np.float64] | None,
    reach: float,
) -> NDArray[np.float64]:
    """Return where dots must stay, shape (count, 2): those that are dots of the old map; NaN for the others."""
    fixed = np.full((count, 2), np.nan)
    if old is None:
        return fixed
    free = adjust(sightings, states, fixed, BodyPriors(position, 1.0, 1.0), iterations=0)
    seen, known = nearest_pairs(old, free.dots, reach)
    fixed[seen] = old[known]
    return fixed


def _result(
    images: Sequence[SurveyImage],
    used: NDArray[np.int64],
    sightings: Sightings,
    adjusted: Adjusted,
    fixed: NDArray[np.float64],
    outline: ViewOutline,
    existing: DotMap | None,
    loops: int,
    left_out: NDArray[np.int64],
) -> SurveyResult:
    """Put dots, diameters and counts together, without dirt."""
    seen = np.bincount(sightings.dot, minlength=len(adjusted.dots))
    diameter = _diameters(sightings, adjusted)
    margin = float(np.nanmedian(diameter))
    expected = count_views(adjusted.dots, images, adjusted.states, outline, margin)
    is_new = np.isnan(fixed[:, 0]) & (seen > 0)
    dirt = is_new & (seen == 1) & (expected >= _SEVERAL)
    kept = is_new & ~dirt
    points, diameters, counts = adjusted.dots[kept], diameter[kept], seen[kept]
    old_dots = 0
    if existing is not None:
        old_dots = len(existing)
        again = np.zeros(old_dots, dtype=np.int64)
        known = np.flatnonzero(~np.isnan(fixed[:, 0]))
        _, which = cKDTree(existing.points).query(fixed[known])
        np.add.at(again, which, seen[known])
        points = np.vstack([existing.points, points])
        diameters = np.concatenate([existing.diameters, diameters])
        counts = np.concatenate([again, counts])
    return SurveyResult(
        DotMap(points, diameters), counts, used, adjusted.states, sightings, adjusted.residuals,
        loops, int(dirt.sum()), left_out, old_dots,
    )  # fmt: skip


def _diameters(sightings: Sightings, adjusted: Adjusted) -> NDArray[np.float64]:
    """Return the mean diameter of each dot, shape (m,) [m]."""
    each = sightings.diameters * (1.0 + adjusted.states[sightings.image, 3])
    total = np.bincount(sightings.dot, each, len(adjusted.dots))
    return total / np.maximum(np.bincount(sightings.dot, minlength=len(adjusted.dots)), 1)
