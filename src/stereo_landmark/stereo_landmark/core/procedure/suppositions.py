"""Suppositions where the robot is: the detection paths of the procedure tree (paper 3.4, figs 7 and 8).

Each primitive of a target is taken as the first of a path, the surest one first. Where one that looks like it was
found, its place in space and each turn that the robot may have made give a pose, and the pose gives the windows in
which the others are looked for. Suppositions that find the same primitives are one.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
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
    kept: dict[tuple[int, ...], tuple[tuple[float, ...], Supposition]] = {}
    for path, found in enumerate(candidates):
        if not len(found):
            continue
        states = states_through(positions[path], found.positions, yaws).reshape(-1, 4)
        states = states[np.hypot(states[:, 0], states[:, 1]) <= settings.reach]
        if not len(states):
            continue
        matched, misfits = _match(states, positions, candidates, view, settings, path)
        counts = (matched >= 0).sum(axis=1)
        for i in np.flatnonzero(counts >= max(1.0, settings.seen_min * len(positions))):
            key = tuple(matched[i].tolist())
            rank = (-float(counts[i]), float(misfits[i]))
            if key not in kept or rank < kept[key][0]:
                kept[key] = rank, Supposition(states[i], matched[i], path)
    ranked = sorted(kept.values(), key=lambda pair: (pair[0][0], pair[1].path, pair[0][1]))
    return [supposition for _, supposition in ranked[:KEPT_MAX]]


def _match(
    states: NDArray[np.float64],
    positions: NDArray[np.float64],
    candidates: Sequence[StereoCandidates],
    view: StereoView,
    settings: SearchSettings,
    path: int,
) -> tuple[NDArray[np.int64], NDArray[np.float64]]:
    """Return the candidate of each primitive in its window, shape (h, k), -1 for none, and the mean misfit, (h,)."""
    pixels = expected_pixels(states, positions, view)
    ways = np.hypot(*(pixels[:, :, :2] - pixels[:, path : path + 1, :2]).transpose(2, 0, 1))
    windows = settings.window + WAY_SHARE * ways
    matched = np.full(pixels.shape[:2], -1)
    misfits = np.full(pixels.shape[:2], np.nan)
    for k, found in enumerate(candidates):
        if not len(found):
            continue
        offsets = pixels[:, k, None, :3] - found.centres[None]
        disparities = (offsets[..., 0] - offsets[..., 2]) / DISPARITY_SHARE
        apart = np.sqrt(offsets[..., 0] ** 2 + offsets[..., 1] ** 2 + disparities**2) / windows[:, k, None]
        apart[np.isnan(apart)] = np.inf
        nearest = apart.argmin(axis=1)
        rows = np.arange(len(states))
        is_near = apart[rows, nearest] < 1.0
        matched[is_near, k] = nearest[is_near]
        misfits[is_near, k] = apart[rows, nearest][is_near]
    with np.errstate(invalid='ignore'):
        mean = np.nansum(misfits, axis=1) / np.maximum((~np.isnan(misfits)).sum(axis=1), 1)
    return matched, mean
