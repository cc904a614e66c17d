"""Checks that a stereo pair is rectified: a point is in the same row of both images, farther left in the right one.

Grilles, shelves and keypads match wrongly, so only matches that are mutually best, clearly better than the second best
and consistent with one epipolar geometry are believed; where few remain, there is no judgement.
"""

from dataclasses import dataclass
from enum import Enum
from typing import Any

import cv2
import numpy as np

from stereo_landmark.core.arrays import Floats, GreyImage
from stereo_landmark.core.stereo import StereoRig

FEATURES, PYRAMID_LEVELS = 1000, 3
"""Number of ORB features; those of higher levels of the pyramid are too coarse."""
RATIO_MAX = 0.8
"""Largest Hamming distance of a match relative to that of the second best one (Lowe's ratio test)."""
MATCHES_MIN = 25
CONSISTENT_MIN = 0.6
"""Smallest number and fraction of matches that agree on one epipolar geometry, for a judgement."""
EPIPOLAR_DISTANCE = 1.5
ROW_DIFFERENCE_MAX = 0.8
"""Largest median row difference of a rectified pair; about 0.1 px is usual [px]."""
ROW_SPREAD_MAX = 1.6
"""Largest median distance of the row differences from their median [px]."""
NEGATIVE_FRACTION_MAX = 0.7
NEGATIVE_DISPARITY = -1.0
"""Matches with a smaller disparity count as negative [px]."""
_FLOW: dict[str, Any] = {'winSize': (11, 11), 'maxLevel': 0, 'flags': cv2.OPTFLOW_USE_INITIAL_FLOW}


class PairFault(Enum):
    """Fault of a stereo pair and its remedy."""

    NOT_RECTIFIED = (
        'matching points are in different rows of the left and the right image, so they are not rectified; '
        'give rectified images, or raw ones with rectify, or calibrate the pair again'
    )
    SWAPPED = 'disparities are negative, so left and right are swapped; swap the two cameras'


@dataclass(frozen=True)
class PairCheck:
    """Result of the check.

    Attributes:
        matches: number of consistent matches.
        row_difference: median of right minus left row [px]; NaN where too few points match for a judgement.
        row_spread: median distance from that median [px].
        fault: fault of the pair, None if there is none or no judgement.
    """

    matches: int
    row_difference: float = float('nan')
    row_spread: float = float('nan')
    fault: PairFault | None = None

    @property
    def summary(self) -> str:
        """The result in one line."""
        if np.isnan(self.row_difference):
            return f'rectification not checked: {self.matches} points match reliably, {MATCHES_MIN} are needed'
        rows = f'rows differ by {self.row_difference:.2f} px, spread {self.row_spread:.2f} px ({self.matches} points)'
        return rows if self.fault is None else f'{self.fault.value} ({rows})'


def check_pair(left: GreyImage, right: GreyImage, rig: StereoRig) -> PairCheck:
    """Check a stereo pair.

    Args:
        left: rectified grey image of the left camera, shape (h, w).
        right: rectified grey image of the right camera, shape (h, w).
        rig: rectified cameras.
    """
    # 1. Reliable matches of one epipolar geometry.
    here, there = _match_features(left, right)
    if len(here) < MATCHES_MIN:
        return PairCheck(len(here))
    _, inliers = cv2.findFundamentalMat(here, there, cv2.FM_RANSAC, EPIPOLAR_DISTANCE, 0.999, 500)
    kept = np.zeros(len(here), dtype=np.bool_) if inliers is None else inliers.ravel() > 0
    if kept.sum() < max(MATCHES_MIN, CONSISTENT_MIN * len(kept)):
        return PairCheck(int(kept.sum()))
    # 2. Rows, to a fraction of a pixel by the grey values.
    here, there = here[kept], there[kept]
    start = there.astype(np.float32)
    exact, found, _ = cv2.calcOpticalFlowPyrLK(left, right, here.astype(np.float32), start.copy(), **_FLOW)
    is_near = (found.ravel() > 0) & (np.abs(exact - start).max(axis=1) < EPIPOLAR_DISTANCE)
    there = np.where(is_near[:, None], exact, there)
    differences = there[:, 1] - here[:, 1]
    median = float(np.median(differences))
    spread = float(np.median(np.abs(differences - median)))
    # 3. Disparities.
    disparities = (here[:, 0] - rig.left.cx) - (there[:, 0] - rig.right.cx)
    fault = None
    if abs(median) > ROW_DIFFERENCE_MAX or spread > ROW_SPREAD_MAX:
        fault = PairFault.NOT_RECTIFIED
    elif float(np.mean(disparities < NEGATIVE_DISPARITY)) > NEGATIVE_FRACTION_MAX:
        fault = PairFault.SWAPPED
    return PairCheck(len(here), median, spread, fault)


def _match_features(left: GreyImage, right: GreyImage) -> tuple[Floats, Floats]:
    """Return matching ORB keypoints in both images, each of shape (n, 2) [px]."""
    detector = cv2.ORB.create(FEATURES, nlevels=PYRAMID_LEVELS)
    (points, descriptors), (other_points, other_descriptors) = (
        detector.detectAndCompute(i, None) for i in (left, right)
    )
    if descriptors is None or other_descriptors is None:
        return np.empty((0, 2)), np.empty((0, 2))
    matcher = cv2.BFMatcher(cv2.NORM_HAMMING)
    forward = {match.queryIdx: match.trainIdx for (match,) in matcher.knnMatch(descriptors, other_descriptors, k=1)}
    best = [pair for pair in matcher.knnMatch(other_descriptors, descriptors, k=2) if len(pair) == 2]
    chosen = [
        one
        for one, other in best
        if one.distance < RATIO_MAX * other.distance and forward.get(one.trainIdx) == one.queryIdx
    ]
    here = np.array([points[match.trainIdx].pt for match in chosen], dtype=np.float64)
    there = np.array([other_points[match.queryIdx].pt for match in chosen], dtype=np.float64)
    return here.reshape(-1, 2), there.reshape(-1, 2)
