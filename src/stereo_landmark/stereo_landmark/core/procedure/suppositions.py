"""Suppositions where the robot is: the detection paths of the procedure tree (paper 3.4, figs 7 and 8).

Each primitive of a target is taken as the first of a path, the surest one first. Where one that looks like it was
found, its place in space and each turn that the robot may have made give a pose, and the pose gives the windows in
which the others are looked for. Suppositions that find the same primitives are one.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numba import njit
from numpy.typing import NDArray

from stereo_landmark.core.procedure.prediction import expected_pixels, states_through
from stereo_landmark.core.procedure.settings import SearchSettings
from stereo_landmark.core.procedure.stereo_candidates import StereoCandidates
from stereo_landmark.core.procedure.stereo_view import StereoView

TURN_STEP = 0.09
"""Between the turns that are tried [rad]."""
WAY_SHARE = 0.08
"""The window of a primitive grows by this share of its way from the first one of the path."""
DISPARITY_SHARE = 0.5
"""Disparities are off by less than places, by about this factor."""
KEPT_MAX = 24
"""Suppositions that are looked at more closely."""
_Tried = tuple[NDArray[np.float64], NDArray[np.int64], NDArray[np.float64], NDArray[np.int64]]
"""States, matches, misfits and paths."""


@dataclass(frozen=True)
class Supposition:
    """A supposed pose and the primitives that speak for it.

    Attributes:
        state: shape (4,), x, y, z [m] and yaw [rad] of the robot in the place's frame.
        matched: shape (k,), the candidate of each primitive of the target, -1 for none.
        path: the primitive that its path began with.
    """

    state: NDArray[np.float64]
    matched: NDArray[np.int64]
    path: int


def suppose(
    positions: NDArray[np.float64],
    candidates: Sequence[StereoCandidates],
    view: StereoView,
    settings: SearchSettings,
) -> list[Supposition]:
    """Return different suppositions, those that find most first; of equal ones those of the surer path.

    Args:
        positions: shape (k, 3), of the target's primitives in the place's frame, the surest first [m].
        candidates: of each of them.
        view: both images.
        settings: where the robot may be.
    """
    yaws = np.arange(-settings.turn, settings.turn + 0.5 * TURN_STEP, TURN_STEP)
    needed = math.ceil(max(1.0, settings.seen_min * len(positions)) - 1e-9)
    starts = np.cumsum([0, *(len(found) for found in candidates)])
    centres = np.concatenate([np.empty((0, 3)), *(found.centres for found in candidates)])
    order = np.concatenate([np.argsort(found.centres[:, 1], kind='stable') for found in candidates])
    tried: list[_Tried] = []
    for path, found in enumerate(candidates):
        states = states_through(positions[path], found.positions, yaws).reshape(-1, 4)
        states = states[np.hypot(states[:, 0], states[:, 1]) <= settings.reach]
        pixels = expected_pixels(states, positions, view)
        matched, misfits = _match(pixels, starts, centres, order, path, settings.window, needed)
        kept = np.flatnonzero(misfits < math.inf)
        tried.append((states[kept], matched[kept], misfits[kept], np.full(len(kept), path)))
    return _best_of(*(np.concatenate(parts) for parts in zip(*tried, strict=True)))


def _best_of(
    states: NDArray[np.float64],
    matched: NDArray[np.int64],
    misfits: NDArray[np.float64],
    paths: NDArray[np.int64],
) -> list[Supposition]:
    """Return suppositions, of those with the same matches the one that fits best."""
    counts = (matched >= 0).sum(axis=1)
    chosen: list[int] = []
    # Those that find most come first, so that few need to be compared.
    for count in np.unique(counts)[::-1].tolist():
        alike = np.flatnonzero(counts == count)
        alike = alike[np.argsort(misfits[alike], kind='stable')]
        best = {row.tobytes(): i for i, row in zip(alike[::-1].tolist(), matched[alike[::-1]], strict=True)}
        chosen += sorted(best.values(), key=lambda i: (paths[i], misfits[i]))
        if len(chosen) >= KEPT_MAX:
            break
    return [Supposition(states[i], matched[i], int(paths[i])) for i in chosen[:KEPT_MAX]]


@njit(cache=True, error_model='numpy')
def _match(
    pixels: NDArray[np.float64],
    starts: NDArray[np.int64],
    centres: NDArray[np.float64],
    order: NDArray[np.int64],
    path: int,
    window: float,
    needed: int,
) -> tuple[NDArray[np.int64], NDArray[np.float64]]:
    """Return the candidate of each primitive in its window, shape (h, k), -1 for none, and the mean misfit, (h,).

    Args:
        pixels: shape (h, k, 4), where the primitives are expected.
        starts: shape (k + 1,), where the candidates of each begin.
        centres: shape (n, 3), of the candidates: u, v left and u right [px].
        order: shape (n,), the numbers of the candidates of each primitive by rising v.
        path: the primitive that the path begins with.
        window: its half width at the first primitive [px].
        needed: poses that find fewer primitives have an infinite misfit.
    """
    count = pixels.shape[1]
    matched = np.full(pixels.shape[:2], -1)
    misfits = np.full(len(pixels), np.inf)
    sorted_centres, firsts = _by_rows(starts, centres, order)
    for h in range(len(pixels)):
        found, total = 0, 0.0
        for k in range(count):
            if found + count - k < needed:
                break
            du, dv = pixels[h, k, 0] - pixels[h, path, 0], pixels[h, k, 1] - pixels[h, path, 1]
            reach = window + WAY_SHARE * np.sqrt(du * du + dv * dv)
            i, apart = _nearest(pixels[h, k], sorted_centres, firsts[k], starts[k + 1], order, reach)
            if i >= 0:
                matched[h, k] = i
                found += 1
                total += apart / reach
        if found >= needed:
            misfits[h] = total / found
    return matched, misfits


@njit(cache=True, error_model='numpy')
def _by_rows(
    starts: NDArray[np.int64], centres: NDArray[np.float64], order: NDArray[np.int64]
) -> tuple[NDArray[np.float64], NDArray[np.int64]]:
    """Return the candidates of each primitive by rising v, and the first one that is not above each row of pixels.

    Returns:
        centres, shape (n, 3), and numbers among them, shape (k, rows).
    """
    count = len(starts) - 1
    ordered = np.empty((len(centres), 3))
    for k in range(count):
        for i in range(starts[k], starts[k + 1]):
            ordered[i] = centres[starts[k] + order[i]]
    rows = int(max(np.max(centres[:, 1]), 0.0)) + 2 if len(centres) else 1
    firsts = np.empty((count, rows), np.int64)
    for k in range(count):
        i = starts[k]
        for row in range(rows):
            while i < starts[k + 1] and ordered[i, 1] < row:
                i += 1
            firsts[k, row] = i
        firsts[k, 0] = starts[k]
    return ordered, firsts


@njit(cache=True, error_model='numpy')
def _nearest(
    expected: NDArray[np.float64],
    centres: NDArray[np.float64],
    firsts: NDArray[np.int64],
    end: int,
    order: NDArray[np.int64],
    reach: float,
) -> tuple[int, float]:
    """Return the number of the candidate nearest to a place and its distance [px]; -1 where none is within reach.

    Args:
        expected: shape (4,) [px].
        centres: shape (n, 3), by rising v [px].
        firsts: shape (rows,), see `_by_rows`.
        end: of this primitive's candidates.
        order: shape (n,), their numbers.
        reach: [px].
    """
    best, least = -1, reach * reach
    top = max(expected[1] - reach, 0.0)
    # Not so where the place is not a number: then nothing is near.
    if not top < len(firsts):
        return best, reach
    for i in range(firsts[int(top)], end):
        dv = expected[1] - centres[i, 1]
        if -dv > reach:
            break
        du = expected[0] - centres[i, 0]
        disparity = (du - expected[2] + centres[i, 2]) / DISPARITY_SHARE
        square = du * du + dv * dv + disparity * disparity
        if square < least or (square == least and best >= 0 and order[i] < best):
            best, least = order[i], square
    return best, np.sqrt(least)
