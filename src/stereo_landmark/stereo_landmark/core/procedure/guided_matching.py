"""Candidates similar to a taught primitive, and guided matching at the pixels that a fitted pose predicts.

A pose hypothesis matches the primitive nearest to the centre of a window. On nested or adjacent outlines, as on a
panel, that is often a wrong one. The fitted pose predicts each point in both images to a few pixels.
"""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numba import njit

from stereo_landmark.core.arrays import Floats, Ints, Masks
from stereo_landmark.core.primitives.primitive import PrimitiveKind, Tolerances, shape_differences, shape_vectors
from stereo_landmark.core.primitives.quadrilateral_kernels import order_corner_pairs
from stereo_landmark.core.procedure.coarse_pose import fit_coarse_pose, predict_pixels
from stereo_landmark.core.procedure.stereo_view import DetectedPrimitives, NamedPair, StereoView, align_pair
from stereo_landmark.core.procedure.taught_place import TaughtPrimitive, TaughtTarget
from stereo_landmark.core.stereo import SpatialPoints


@dataclass(frozen=True)
class StereoCandidates:
    """Detected stereo pairs that are similar to one taught primitive.

    Attributes:
        left: indices among the primitives of the kind in the left image, shape (n,).
        right: indices in the right image, shape (n,).
        centres: u, v left and u right of the centres, shape (n, 3) [px].
        positions: centres in the gravity-aligned base frame, shape (n, 3) [m].
        points: invariant points in the order of the taught one's, u, v left and u, v right, shape (n, p, 4) [px].
    """

    left: Ints
    right: Ints
    centres: Floats
    positions: Floats
    points: Floats

    def __len__(self) -> int:
        return len(self.left)


def find_stereo_candidates(
    taught: Sequence[TaughtPrimitive], view: StereoView, depths: Floats, tolerances: Tolerances
) -> list[StereoCandidates]:
    """Find the stereo candidates of each taught primitive.

    Args:
        taught: k taught primitives.
        view: stereo view.
        depths: smallest and largest accepted depth of each, shape (k, 2) [m].
        tolerances: tolerances of the shape comparison.
    """
    similar = similar_primitives(taught, view.left.kinds, tolerances)
    return [
        _find_candidates(each, np.flatnonzero(row), view, limits)
        for each, row, limits in zip(taught, similar, depths, strict=True)
    ]


def similar_primitives(
    taught: Sequence[TaughtPrimitive], kinds: dict[PrimitiveKind, DetectedPrimitives], tolerances: Tolerances
) -> list[Masks]:
    """Return for each taught primitive the mask of primitives within the tolerances, each of shape (n,)."""
    rows: dict[int, Masks] = {}
    for kind, detected in kinds.items():
        indices = [k for k, each in enumerate(taught) if each.kind is kind]
        if indices:
            shapes = shape_vectors(kind, [taught[k].shape for k in indices])
            rows.update(
                zip(indices, shape_differences(kind, detected.shape_vectors, shapes, tolerances) <= 1.0, strict=True)
            )
    return [rows[k] for k in range(len(taught))]


def _find_candidates(taught: TaughtPrimitive, similar: Ints, view: StereoView, depths: Floats) -> StereoCandidates:
    here, there = view.detected_pair(taught.kind)
    right = view.match_indices(taught.kind)[similar]
    left, right = similar[right >= 0], right[right >= 0]
    pixels = np.column_stack([here.centres[left], there.centres[right]])
    points = view.rig.back_project(pixels)
    kept = (points[:, 2] >= depths[0]) & (points[:, 2] <= depths[1])
    positions = points[kept] @ view.camera.rotation.T + view.camera.position
    left, right, pixels = left[kept], right[kept], pixels[kept]
    return StereoCandidates(left, right, pixels[:, :3], positions, _invariant_points(taught, left, right, view, pixels))


def _invariant_points(taught: TaughtPrimitive, left: Ints, right: Ints, view: StereoView, centres: Floats) -> Floats:
    """Return the corners of quadrilaterals, shape (n, 4, 4), and the centres of other kinds, shape (n, 1, 4) [px]."""
    if taught.kind is not PrimitiveKind.QUADRILATERAL:
        return centres[:, None]
    here, there = view.detected_pair(taught.kind)
    (first,) = shape_vectors(taught.kind, [taught.shape])
    corners = order_corner_pairs(here.shape_vectors[left], there.shape_vectors[right], first)
    return np.asarray(corners + centres[:, None])


def fit_points(
    start: Floats, taught: Sequence[SpatialPoints], seen: dict[int, Floats], view: StereoView
) -> Floats | None:
    """Fit the pose to points of some of the taught primitives, each of shape (p, 4) [px]; None if not observable."""
    if not seen:
        return None
    positions = np.concatenate([taught[k].positions for k in seen])
    covariances = np.concatenate([taught[k].covariances for k in seen])
    return fit_coarse_pose(start, positions, covariances, np.concatenate(list(seen.values())), view)


def named_pairs(target: TaughtTarget, matched: dict[int, tuple[int, int]], view: StereoView) -> list[NamedPair]:
    """Return the primitives of both images that are matched to some of the target's primitives, by their indices."""
    pairs: list[NamedPair] = []
    for k, (left, right) in matched.items():
        taught = target.primitives[k]
        here, there = view.detected_pair(taught.kind)
        pair = align_pair(taught.shape, here.primitives[left], there.primitives[right])
        pairs.append((f'{target.name}/{taught.name}', *pair))
    return pairs


@dataclass(frozen=True)
class _Candidates:
    """Detected primitives of one image that are similar to a taught primitive.

    Attributes:
        indices: indices among the primitives of the kind, shape (n,).
        points: points in the order of the taught primitive's, shape (n, p, 2) [px].
        expected_sizes: sizes of ellipses, which have only one point, shape (n,) [px]; shape (0,) for other kinds.
    """

    indices: Ints
    points: Floats
    expected_sizes: Floats


class GuidedMatcher:
    """Matches one target by guided matching.

    Args:
        target: taught target.
        points: taught points of each of its primitives, in the place's frame.
        view: stereo view.
        tolerances: tolerances of the shape comparison.
    """

    def __init__(
        self, target: TaughtTarget, points: Sequence[SpatialPoints], view: StereoView, tolerances: Tolerances
    ) -> None:
        self._target, self._points, self._view = target, points, view
        self._centres = np.array([taught.position for taught in target.primitives])
        self._sizes = np.array([taught.size for taught in target.primitives])
        self._candidates = [
            _candidates(target.primitives, scene.kinds, tolerances) for scene in (view.left, view.right)
        ]

    def match(self, states: Floats, window: float) -> Ints:
        """Return the candidates nearest to the predicted points in the left and right image, shape (h, k, 2).

        Args:
            states: x, y, z [m] and yaw [rad] of the robot in the place's frame, shape (h, 4).
            window: maximum distance of each point from its prediction [px].

        Returns:
            candidate indices for `fit` and `pairs`; -1 without a match.
        """
        expected_sizes = self._sizes * self._depths(np.zeros((1, 4))) / self._depths(states)
        chosen = np.full((len(states), len(self._points), 2), -1)
        for k, taught in enumerate(self._points):
            pixels = predict_pixels(states, taught.positions, self._view)
            for side in range(2):
                expected, candidates = pixels[:, :, 2 * side : 2 * side + 2], self._candidates[side][k]
                chosen[:, k, side] = _match_nearest(
                    candidates.points, candidates.expected_sizes, expected, expected_sizes[:, k], window
                )
        chosen[(chosen < 0).any(axis=2)] = -1
        return chosen

    def fit(self, state: Floats, chosen: Ints) -> Floats | None:
        """Fit the pose to the detected primitives, shape (4,); None if it is not observable.

        Args:
            state: initial state, shape (4,).
            chosen: candidate indices from `match`, shape (k, 2).
        """
        seen = {
            k: np.hstack([self._candidates[side][k].points[chosen[k, side]] for side in range(2)])
            for k in np.flatnonzero(chosen[:, 0] >= 0).tolist()
        }
        return fit_points(state, self._points, seen, self._view)

    def pairs(self, chosen: Ints) -> list[NamedPair]:
        """Return the matched primitives of both images; ``chosen`` as in `fit`."""
        matched = {
            k: (self._candidates[0][k].indices[left], self._candidates[1][k].indices[right])
            for k, (left, right) in enumerate(chosen.tolist())
            if left >= 0
        }
        return named_pairs(self._target, matched, self._view)

    def _depths(self, states: Floats) -> Floats:
        """Return the depths of the primitives, shape (h, k) [m]."""
        pixels = predict_pixels(states, self._centres, self._view)
        rig = self._view.rig
        return np.asarray(rig.left.fx * rig.baseline / rig.disparities(pixels))


def _candidates(
    taught: tuple[TaughtPrimitive, ...], kinds: dict[PrimitiveKind, DetectedPrimitives], tolerances: Tolerances
) -> list[_Candidates]:
    return [
        _make_candidates(each, kinds[each.kind], np.flatnonzero(row))
        for each, row in zip(taught, similar_primitives(taught, kinds, tolerances), strict=True)
    ]


def _make_candidates(taught: TaughtPrimitive, detected: DetectedPrimitives, indices: Ints) -> _Candidates:
    centres = detected.centres[indices][:, None]
    if taught.kind is not PrimitiveKind.QUADRILATERAL:
        expected_sizes = detected.shape_vectors[indices, 0] if taught.kind is PrimitiveKind.ELLIPSE else np.empty(0)
        return _Candidates(indices, centres, expected_sizes)
    shapes = detected.shape_vectors[indices]
    (first,) = shape_vectors(taught.kind, [taught.shape])
    return _Candidates(indices, order_corner_pairs(shapes, shapes, first)[..., :2] + centres, np.empty(0))


@njit(cache=True, error_model='numpy')
def _match_nearest(
    points: Floats, point_sizes: Floats, expected: Floats, expected_sizes: Floats, window: float
) -> Ints:
    """Return the index of the nearest candidate for each row of predicted points; -1 outside of the window.

    Candidates have the shape (n, p, 2) and sizes (n,), or (0,) to ignore sizes; predictions (h, p, 2) and (h,)
    [px]. NaN matches nothing.
    """
    nearest = np.full(len(expected), -1)
    for h in range(len(expected)):
        smallest = window
        for i in range(len(points)):
            misfit = abs(point_sizes[i] - expected_sizes[h]) if len(point_sizes) else 0.0
            for p in range(expected.shape[1]):
                if not misfit < smallest:
                    break
                du, dv = expected[h, p, 0] - points[i, p, 0], expected[h, p, 1] - points[i, p, 1]
                # Unlike max(), this comparison propagates NaN.
                distance = np.sqrt(du * du + dv * dv)
                misfit = distance if not distance < misfit else misfit
            if misfit < smallest:
                smallest, nearest[h] = misfit, i
    return nearest
