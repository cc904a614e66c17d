"""Epipolar check: whether two images are a rectified stereo pair, by ORB matches."""

from __future__ import annotations

from enum import Enum

import cv2
import numpy as np
from numpy.typing import NDArray

from stereo_landmark.core.stereo import StereoRig

FEATURES = 600
PYRAMID_LEVELS = 3
"""Levels of the ORB pyramid; keypoints of higher levels are too coarse."""
HAMMING_DISTANCE_MAX = 48
"""Largest Hamming distance between matching descriptors."""
MATCH_ROW_DIFFERENCE_MAX = 60.0
"""Largest row difference of a match [px]."""
MATCHES_MIN = 25
"""Minimum number of matches for a decision."""
ROW_DIFFERENCE_MAX = 1.6
"""Largest median row difference of a rectified pair [px]; about 0.4 px is usual."""
NEGATIVE_FRACTION_MAX = 0.7
"""Largest fraction of matches with a negative disparity."""
NEGATIVE_DISPARITY = -1.0
"""Matches with a smaller disparity count as negative [px]."""


class PairFault(Enum):
    """Fault of a stereo pair and its remedy."""

    NOT_RECTIFIED = (
        'matching points are in different rows of the left and the right image, so they are not rectified; '
        'give rectified images, or raw ones with rectify, or calibrate the pair again'
    )
    SWAPPED = 'disparities are negative, so left and right are swapped; swap the two cameras'


def pair_fault(left: NDArray[np.uint8], right: NDArray[np.uint8], rig: StereoRig) -> PairFault | None:
    """Return the fault of a stereo pair, None if it has none or the images have too few features.

    Args:
        left: rectified grey image of the left camera, shape (h, w).
        right: rectified grey image of the right camera, shape (h, w).
        rig: rectified cameras.
    """
    left_points, right_points = _match_features(left, right)
    row_differences = np.abs(left_points[:, 1] - right_points[:, 1])
    if len(row_differences) < MATCHES_MIN:
        return None
    if float(np.median(row_differences)) > ROW_DIFFERENCE_MAX:
        return PairFault.NOT_RECTIFIED
    disparities = (left_points[:, 0] - rig.left.cx) - (right_points[:, 0] - rig.right.cx)
    is_negative = disparities[row_differences < ROW_DIFFERENCE_MAX] < NEGATIVE_DISPARITY
    return PairFault.SWAPPED if float(np.mean(is_negative)) > NEGATIVE_FRACTION_MAX else None


def _match_features(
    left: NDArray[np.uint8], right: NDArray[np.uint8]
) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """Return matching ORB keypoints in both images, each of shape (n, 2) [px]."""
    detector = cv2.ORB.create(FEATURES, nlevels=PYRAMID_LEVELS)
    (points, descriptors), (other_points, other_descriptors) = (
        detector.detectAndCompute(i, None) for i in (left, right)
    )
    if descriptors is None or other_descriptors is None:
        return np.empty((0, 2)), np.empty((0, 2))
    found = cv2.BFMatcher(cv2.NORM_HAMMING, crossCheck=True).match(descriptors, other_descriptors)
    near = [match for match in found if match.distance <= HAMMING_DISTANCE_MAX]
    left_points = np.array([points[match.queryIdx].pt for match in near], dtype=np.float64).reshape(-1, 2)
    right_points = np.array([other_points[match.trainIdx].pt for match in near], dtype=np.float64).reshape(
        -1, 2
    )
    kept = np.abs(left_points[:, 1] - right_points[:, 1]) < MATCH_ROW_DIFFERENCE_MAX
    return left_points[kept], right_points[kept]
