"""Trinocular depth of three cameras in an L: a horizontal and a vertical pair, fused by agreement or union (2.2.1)."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from numba import njit
from numpy.typing import NDArray

from reward_planner.core.depth.stereo_pair import PairMatcher, StereoPair, pair_from_projections
from reward_planner.core.reward_planner_error import RewardPlannerError
from reward_planner.core.settings import DepthSettings
from shirube_core.geometry import PinholeCamera

NO_RETURN = np.float32(1000.0)
"""Depth of a ray that returned nothing: farther than any ``range_max`` [m]."""


def points_from_depth_image(
    depth: NDArray[np.float32], camera: PinholeCamera, shear: float = 0.0, nearest: float = 0.0
) -> NDArray[np.float32]:
    """Return the points of the pixels in the optical frame [m], shape (n, 3).

    REP 118: +inf is nothing within range, here a point farther than any range, whose ray clears space; -inf is too
    close to measure, an obstacle at the distance ``nearest`` [m], left out without one; NaN and depths of 0 and less
    are unknown and left out. The shear is P[0, 1] of the rectified image [px], see `rig_calibration`.

    Raises:
        RewardPlannerError: the sizes of image and camera differ, or the camera has distortion.
    """
    if depth.shape != (camera.height, camera.width):
        raise RewardPlannerError(
            f'the depth image has {depth.shape[::-1]} pixels, camera_info {camera.width} x {camera.height}; '
            'they must be equal'
        )
    if camera.has_distortion:
        raise RewardPlannerError('the camera of the depth image has distortion; give a rectified image')
    image = np.ascontiguousarray(depth, dtype=np.float32)
    return _points(image, (camera.fx, camera.fy, camera.cx, camera.cy, shear), nearest)


@njit(cache=True)
def _points(
    depth: NDArray[np.float32], intrinsics: tuple[float, float, float, float, float], nearest: float
) -> NDArray[np.float32]:
    fx, fy, cx, cy, shear = intrinsics
    points = np.empty((depth.size, 3), dtype=np.float32)
    count = 0
    for row in range(depth.shape[0]):
        for column in range(depth.shape[1]):
            z = depth[row, column]
            if z > 0.0 or (z == -np.inf and nearest > 0.0):
                y = (row - cy) / fy
                x = (column - cx - shear * y) / fx
                if z == np.inf:
                    z = NO_RETURN
                elif z == -np.inf:
                    z = nearest / math.sqrt(1.0 + x * x + y * y)
                points[count, 0] = x * z
                points[count, 1] = y * z
                points[count, 2] = z
                count += 1
    return points[:count]


NO_DEPTH, FIRST, SECOND, BOTH, INCONSISTENT = range(5)
"""Source of a depth: the pairs that measured it; inconsistent pairs give no depth."""

_INCONSISTENT_FRACTION_MAX = 0.5  # consistent pairs differ in a few percent of the pixels
_OVERLAP_MIN = 0.01  # least fraction of pixels that both pairs see for a consistency check


@dataclass(frozen=True)
class DepthImage:
    """Depth image of the left camera.

    Attributes:
        depth: depth along the optical axis [m], NaN for none, shape (height, width).
        source: NO_DEPTH, FIRST, SECOND, BOTH or INCONSISTENT, shape (height, width).
    """

    depth: NDArray[np.float32]
    source: NDArray[np.uint8]

    @property
    def inconsistent_fraction(self) -> float | None:
        """Fraction of the pixels seen by both pairs that are inconsistent; None if these are too few."""
        agreed, inconsistent = (np.count_nonzero(self.source == kind) for kind in (BOTH, INCONSISTENT))
        if agreed + inconsistent < _OVERLAP_MIN * self.source.size:
            return None
        return inconsistent / (agreed + inconsistent)

    def only_consistent(self) -> DepthImage:
        """Return only the depths that both pairs confirm."""
        is_consistent = self.source == BOTH
        depth = np.where(is_consistent, self.depth, np.float32(np.nan))
        is_kept = is_consistent | (self.source == INCONSISTENT)
        return DepthImage(depth, np.where(is_kept, self.source, np.uint8(NO_DEPTH)))


class TrinocularDepth:
    """Matches the left camera with two others, usually the right and the top one."""

    def __init__(self, first: StereoPair, second: StereoPair, settings: DepthSettings) -> None:
        """Prepare the matchers of two pairs, usually of the left with the right and the top camera."""
        self._pairs = (first, second)
        self._matchers = (PairMatcher(first, settings), PairMatcher(second, settings))
        self._settings = settings

    def compute(self, left: NDArray[np.uint8], right: NDArray[np.uint8], top: NDArray[np.uint8]) -> DepthImage:
        """Return the fused depth of both pairs, from rectified grey images of the same shape (height, width).

        Raises:
            RewardPlannerError: images that are not grey or not of the same size.
        """
        first, second = self._matchers[0].match(left, right), self._matchers[1].match(left, top)
        scales = (self._pairs[0].focal_baseline, self._pairs[1].focal_baseline)
        union = self._settings.fusion == 'union'
        return DepthImage(*fuse_disparities(first, second, scales, self._settings.agreement, union))


def depth_from_disparity(disparity: NDArray[np.float32], pair: StereoPair) -> NDArray[np.float32]:
    """Return Z = b f / d (eq. 2) [m], same shape; NaN stays NaN."""
    return np.float32(pair.focal_baseline) / disparity


@njit(cache=True)
def fuse_disparities(
    first: NDArray[np.float32], second: NDArray[np.float32], scales: tuple[float, float], agreement: float, union: bool
) -> tuple[NDArray[np.float32], NDArray[np.uint8]]:
    """Return depth and source of each pixel from the disparities of both pairs [px], NaN for none.

    Pairs that agree are averaged as 1 / Z = d / (b f), with weights (b f)^2: the inverse variance. So the weighted mean
    is the sum of d b f over the sum of (b f)^2. Agreement is measured in pixels of the coarser pair. ``scales`` are b f
    of both pairs [px m]; with ``union``, depths of one pair alone are kept.
    """
    depth = np.full(first.shape, np.nan, dtype=np.float32)
    source = np.zeros(first.shape, dtype=np.uint8)
    tolerance = agreement / min(scales[0], scales[1])
    weight = scales[0] ** 2 + scales[1] ** 2
    for row, column in np.ndindex(first.shape):
        a, b = first[row, column], second[row, column]
        has_a, has_b = not np.isnan(a), not np.isnan(b)
        if has_a and has_b:
            if abs(a / scales[0] - b / scales[1]) <= tolerance:
                depth[row, column] = weight / (a * scales[0] + b * scales[1])
                source[row, column] = BOTH
            else:
                source[row, column] = INCONSISTENT
        elif union and has_a:
            depth[row, column], source[row, column] = scales[0] / a, FIRST
        elif union and has_b:
            depth[row, column], source[row, column] = scales[1] / b, SECOND
    return depth, source


class TrinocularRig:
    """Depth of three cameras.

    Calibrations differ in the sign of the vertical baseline: P[1, 3] is -fy B with B along y, which points down, but
    some tools write a positive B for a camera above as well. Only the right sign makes the pairs consistent.

    If both pairs see too few common pixels for this check (a covered camera, noise, swapped images), only depths that
    both confirm are returned.

    Attributes:
        is_mirrored: whether the top camera is on the opposite side of what its calibration says.
    """

    def __init__(self, projections: NDArray[np.float64], settings: DepthSettings) -> None:
        """Prepare the matchers for projection matrices P of the left, right and top camera, shape (3, 3, 4).

        Raises:
            RewardPlannerError: cameras that are not rectified to each other, or settings that OpenCV does not support.
        """
        left, right, top = projections
        horizontal, vertical = pair_from_projections(left, right), pair_from_projections(left, top)
        self.is_mirrored = False
        self._is_confirmed: bool | None = None  # by the latest frame with enough common pixels
        self._sides = [TrinocularDepth(horizontal, side, settings) for side in (vertical, vertical.mirror())]

    def compute(self, left: NDArray[np.uint8], right: NDArray[np.uint8], top: NDArray[np.uint8]) -> DepthImage:
        """Return the depth; arguments as for `TrinocularDepth.compute`.

        Raises:
            RewardPlannerError: images of a wrong type or shape, or pairs that are inconsistent with either sign, now
                or in the latest frame with enough common pixels.
        """
        depth = self._sides[self.is_mirrored].compute(left, right, top)
        inconsistent = depth.inconsistent_fraction
        if _is_consistent(inconsistent):
            self._is_confirmed = True
            return depth
        if inconsistent is not None or self._is_confirmed is None:
            mirrored_depth = self._sides[not self.is_mirrored].compute(left, right, top)
            if _is_consistent(mirrored_depth.inconsistent_fraction):
                self.is_mirrored, self._is_confirmed = not self.is_mirrored, True
                return mirrored_depth
        if inconsistent is not None:
            self._is_confirmed = False
        if self._is_confirmed is False:
            raise RewardPlannerError(
                'the depths of left-right and left-top are inconsistent; check that the topics are those of these '
                'cameras, and calibrate them together'
            )
        return depth.only_consistent()


def _is_consistent(inconsistent_fraction: float | None) -> bool:
    return inconsistent_fraction is not None and inconsistent_fraction <= _INCONSISTENT_FRACTION_MAX
