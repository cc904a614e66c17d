"""Pose hypotheses from the paths of the procedure tree (paper 3.4, figs 7 and 8), and their score.

Each primitive of a target begins a path, the most reliable one first. The 3D position of each of its candidates and
each tested yaw of the robot determine a pose, and the pose determines the windows in which the other primitives are
searched. Hypotheses that match the same primitives are merged.
"""

import math
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numba import njit

from stereo_landmark.core.arrays import Floats, Ints
from stereo_landmark.core.primitives.primitive import Tolerances
from stereo_landmark.core.procedure.coarse_pose import is_in_view, poses_from_match, predict_pixels
from stereo_landmark.core.procedure.guided_matching import StereoCandidates, similar_primitives
from stereo_landmark.core.procedure.stereo_view import StereoView
from stereo_landmark.core.procedure.taught_place import TaughtPrimitive
from stereo_landmark.core.settings import SearchSettings

YAW_STEP = 0.09
"""Step between the tested yaws [rad]."""
WINDOW_GROWTH = 0.08
"""Growth of a search window per pixel of distance from the first primitive of the path."""
DISPARITY_SCALE = 0.5
"""Ratio of the error of disparities to that of positions."""
HYPOTHESES_MAX = 24
"""Maximum number of hypotheses that are refined."""
SAME_PLACE = 12.0
"""Side of the cells of an image [px]: primitives in one cell, such as nested outlines, count as the same match."""
_Hypotheses = tuple[Floats, Ints, Floats, Ints]
"""States, matches, misfits and paths."""


@dataclass(frozen=True)
class PoseHypothesis:
    """A hypothetical pose and the primitives that support it.

    Attributes:
        state: x, y, z [m] and yaw [rad] of the robot in the place's frame, shape (4,).
        matches: candidate index of each primitive of the target, shape (k,), -1 without a match.
        path: index of the first primitive of its path.
    """

    state: Floats
    matches: Ints
    path: int


def generate_hypotheses(
    positions: Floats, candidates: Sequence[StereoCandidates], view: StereoView, settings: SearchSettings
) -> list[PoseHypothesis]:
    """Return distinct hypotheses, those with the most matches first, in a tie those of the more reliable path.

    Args:
        positions: the target's primitives in the place's frame, the most reliable first, shape (k, 3) [m].
        candidates: stereo candidates of each primitive.
        view: stereo view.
        settings: search settings.
    """
    yaws = np.arange(-settings.yaw_max, settings.yaw_max + 0.5 * YAW_STEP, YAW_STEP)
    count_min = math.ceil(max(1.0, settings.found_fraction_min * len(positions)) - 1e-9)
    starts = np.cumsum([0, *(len(found) for found in candidates)])
    by_row = [np.argsort(found.centres[:, 1], kind='stable') for found in candidates]
    centres = np.concatenate([found.centres[order] for found, order in zip(candidates, by_row, strict=True)])
    columns, order = np.ascontiguousarray(centres.T), np.concatenate(by_row)
    generated: list[_Hypotheses] = []
    for path, found in enumerate(candidates):
        states = poses_from_match(positions[path], found.positions, yaws).reshape(-1, 4)
        states = states[np.hypot(states[:, 0], states[:, 1]) <= settings.distance_max]
        pixels = predict_pixels(states, positions, view)
        matches, misfits = _match(pixels, starts, columns, order, path, settings.window, count_min)
        kept = np.flatnonzero(misfits < math.inf)
        generated.append((states[kept], matches[kept], misfits[kept], np.full(len(kept), path)))
    states, matches, misfits, paths = (np.concatenate(parts) for parts in zip(*generated, strict=True))
    return _select_best(states, matches, misfits, paths, _matched_cells(matches, candidates))


def _matched_cells(matches: Ints, candidates: Sequence[StereoCandidates]) -> Ints:
    """Return a number for the image cell of each match, shape (h, k), -1 without a match."""
    cells = np.full(matches.shape, -1)
    for k, found in enumerate(candidates):
        is_matched = matches[:, k] >= 0
        columns, rows = np.rint(found.centres[:, :2] / SAME_PLACE).astype(np.int64).T
        cells[is_matched, k] = (10000 * rows + columns)[matches[is_matched, k]]
    return cells


def _select_best(states: Floats, matches: Ints, misfits: Floats, paths: Ints, cells: Ints) -> list[PoseHypothesis]:
    """Return hypotheses, of those with matches in the same cells the one with the smallest misfit."""
    counts = (matches >= 0).sum(axis=1)
    chosen: list[int] = []
    # Hypotheses with the most matches come first, so that few need to be compared.
    for count in np.unique(counts)[::-1].tolist():
        alike = np.flatnonzero(counts == count)
        alike = alike[np.argsort(misfits[alike], kind='stable')]
        best = {row.tobytes(): i for i, row in zip(alike[::-1].tolist(), cells[alike[::-1]], strict=True)}
        chosen += sorted(best.values(), key=lambda i: (paths[i], misfits[i]))
        if len(chosen) >= HYPOTHESES_MAX:
            break
    return [PoseHypothesis(states[i], matches[i], int(paths[i])) for i in chosen[:HYPOTHESES_MAX]]


@njit(cache=True, error_model='numpy')
def _match(
    pixels: Floats, starts: Ints, centres: Floats, order: Ints, path: int, window: float, count_min: int
) -> tuple[Ints, Floats]:
    """Return the candidate of each primitive in its window, shape (h, k), -1 without one, and the mean misfit, (h,).

    Predicted pixels have the shape (h, k, 4). Candidates (u, v left and u right) have the shape (3, n), with ``starts``
    of each primitive, shape (k + 1,), by rising v; ``order`` has their indices, shape (n,). Poses with too few matches
    have an infinite misfit.
    """
    count = pixels.shape[1]
    matches = np.full(pixels.shape[:2], -1)
    misfits = np.full(len(pixels), np.inf)
    squared_distances = np.empty(len(order))
    # The primitive with the fewest candidates is tested first: it rejects wrong poses earliest.
    rare_first = np.argsort(np.diff(starts), kind='mergesort')
    for h in range(len(pixels)):
        found, total = 0, 0.0
        for rank in range(count):
            if found + count - rank < count_min:
                break
            k = rare_first[rank]
            du, dv = pixels[h, k, 0] - pixels[h, path, 0], pixels[h, k, 1] - pixels[h, path, 1]
            radius = window + WINDOW_GROWTH * np.sqrt(du * du + dv * dv)
            own = slice(starts[k], starts[k + 1])
            i, apart = _nearest(pixels[h, k], centres[:, own], order[own], radius, squared_distances)
            if i >= 0:
                matches[h, k] = i
                found += 1
                total += apart / radius
        if found >= count_min:
            misfits[h] = total / found
    return matches, misfits


@njit(cache=True, error_model='numpy')
def _nearest(
    expected: Floats, centres: Floats, order: Ints, radius: float, squared_distances: Floats
) -> tuple[int, float]:
    """Return index and distance [px] of the candidate nearest to a predicted pixel; -1 if none is within the radius.

    Candidates have the shape (3, n), by rising v; NaN matches nothing.
    """
    begin = np.searchsorted(centres[1], expected[1] - radius)
    end = np.searchsorted(centres[1], expected[1] + radius, side='right')
    smallest = _write_squared_distances(
        expected, centres[0, begin:end], centres[1, begin:end], centres[2, begin:end], squared_distances
    )
    if not smallest < radius * radius:
        return -1, radius
    best = -1
    for i in range(end - begin):
        if squared_distances[i] == smallest and (best < 0 or order[begin + i] < best):
            best = order[begin + i]
    return best, np.sqrt(smallest)


# The minimum does not depend on the order, so that the loop is vectorized.
@njit(cache=True, error_model='numpy', fastmath={'nnan', 'nsz', 'reassoc'})
def _write_squared_distances(
    expected: Floats, us: Floats, vs: Floats, rights: Floats, squared_distances: Floats
) -> float:
    """Write the squared distances of candidates from a predicted pixel; return the smallest [px²]."""
    u, v, disparity = expected[0], expected[1], expected[0] - expected[2]
    smallest = np.inf
    for i in range(len(us)):
        du, dv, apart = u - us[i], v - vs[i], (disparity - us[i] + rights[i]) / DISPARITY_SCALE
        squared_distance = du * du + dv * dv + apart * apart
        squared_distances[i] = squared_distance
        smallest = min(smallest, squared_distance)
    return smallest


WINDOW = 5.0
"""Maximum distance of a detection from its predicted pixel [px]."""
CENTRE_SIGMA = 1.0
"""Standard deviation of a detection along each axis [px]; it separates rows of different spacing. Rendered scenes show
0.01 px for the fitted primitives and 0.1 px for the context landmarks; real calibrations are worse."""
FALSE_POSITIVE_MIN, FALSE_POSITIVE_MAX = 0.05, 0.5
"""Limits of the probability of a false positive in a window; patterns on walls keep it above the lower limit."""


class PoseScorer:
    """Scores pose hypotheses by the primitives of the left image.

    Args:
        expected: taught primitives: those of the targets and the context landmarks.
        view: stereo view.
        tolerances: tolerances of the shape comparison.
        settings: search settings with the detection probability.
    """

    def __init__(
        self, expected: Sequence[TaughtPrimitive], view: StereoView, tolerances: Tolerances, settings: SearchSettings
    ) -> None:
        self._positions = np.array([primitive.position for primitive in expected]).reshape(-1, 3)
        self._view = view
        similar = similar_primitives(expected, view.left.kinds, tolerances)
        similar_counts = [int(row.sum()) for row in similar]
        self._starts = np.cumsum([0, *similar_counts])
        centres = [view.left.kinds[each.kind].centres[row] for each, row in zip(expected, similar, strict=True)]
        self._centres = np.concatenate([np.empty((0, 2)), *centres])
        self._false_positives = np.array([self._false_positive_probability(primitive) for primitive in expected])
        self._detection_probability = settings.detection_probability

    def score(self, states: Floats) -> Floats:
        """Return the log-likelihood ratios of poses against chance, shape (h,).

        Args:
            states: x, y, z [m] and yaw [rad] in the place's frame, shape (h, 4).
        """
        pixels = predict_pixels(states, self._positions, self._view)
        near = np.exp(-0.5 * _squared_distances(pixels, self._starts, self._centres) / CENTRE_SIGMA**2)
        log_ratios = np.log(
            self._detection_probability * near / self._false_positives + 1.0 - self._detection_probability
        )
        return np.asarray(np.sum(np.where(is_in_view(pixels, self._view.rig), log_ratios, 0.0), axis=1))

    def _false_positive_probability(self, primitive: TaughtPrimitive) -> float:
        """Return the probability that a window contains a primitive of this kind by chance."""
        area = self._view.rig.left.width * self._view.rig.left.height
        count = len(self._view.left.kinds[primitive.kind].primitives)
        return min(max(count * math.pi * WINDOW**2 / area, FALSE_POSITIVE_MIN), FALSE_POSITIVE_MAX)


@njit(cache=True)
def _squared_distances(pixels: Floats, starts: Ints, centres: Floats) -> Floats:
    """Return squared distances to the nearest similar primitives, infinite outside of the window, shape (h, k) [px²].

    Predicted pixels have the shape (h, k, 4), centres the shape (n, 2), with ``starts`` of each primitive, (k + 1,).
    """
    squared_distances = np.full(pixels.shape[:2], np.inf)
    for h in range(pixels.shape[0]):
        for k in range(pixels.shape[1]):
            u, v = pixels[h, k, 0], pixels[h, k, 1]
            for i in range(starts[k], starts[k + 1]):
                squared_distance = (centres[i, 0] - u) ** 2 + (centres[i, 1] - v) ** 2
                if squared_distance <= WINDOW**2 and squared_distance < squared_distances[h, k]:
                    squared_distances[h, k] = squared_distance
    return squared_distances
