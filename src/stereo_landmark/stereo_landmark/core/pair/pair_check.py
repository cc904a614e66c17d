"""Whether two images are a rectified pair, told by points that both show."""

from __future__ import annotations

from enum import Enum

import cv2
import numpy as np
from numpy.typing import NDArray

from stereo_landmark.core.place.stereo_rig import StereoRig

FEATURES = 600
LEVELS = 3
"""Of ORB's pyramid; places on higher levels are too coarse."""
DISTANCE_MAX = 48
"""Bits in which the descriptors of one point differ at most."""
ROWS_MAX = 60.0
"""What is farther apart is no match [px]."""
MATCHES_MIN = 25
"""Fewer tell nothing."""
ROWS_APART_MAX = 1.6
"""Median in rectified pairs is about 0.4 [px]."""
BEHIND_SHARE_MAX = 0.7
"""Of points with the disparity of things behind the cameras."""
BEHIND = -1.0
"""[px]"""


class PairFault(Enum):
    """What is wrong with a pair, and what to do."""

    NOT_RECTIFIED = (
        'the same things are in other rows of the left and the right image, so they are not rectified; '
        'give rectified images, or raw ones with rectify, or calibrate the pair again'
    )
    SWAPPED = (
        'things are farther right in the right image than in the left one, so left and right are swapped; '
        'swap the two cameras'
    )


def pair_fault(left: NDArray[np.uint8], right: NDArray[np.uint8], rig: StereoRig) -> PairFault | None:
    """Return what is wrong with a pair, None where nothing is, or where too little is to be seen.

    Args:
        left: shape (h, w), grey.
        right: the same of the right camera.
        rig: the cameras that the images are said to be of.
    """
    here, there = _matches(left, right)
    rows_apart = np.abs(here[:, 1] - there[:, 1])
    if len(rows_apart) < MATCHES_MIN:
        return None
    if float(np.median(rows_apart)) > ROWS_APART_MAX:
        return PairFault.NOT_RECTIFIED
    disparities = (here[:, 0] - rig.left.cx) - (there[:, 0] - rig.right.cx)
    is_behind = disparities[rows_apart < ROWS_APART_MAX] < BEHIND
    return PairFault.SWAPPED if float(np.mean(is_behind)) > BEHIND_SHARE_MAX else None


def _matches(
    left: NDArray[np.uint8], right: NDArray[np.uint8]
) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """Return places of the same things in both images, each of shape (n, 2) [px]."""
    detector = cv2.ORB.create(FEATURES, nlevels=LEVELS)
    (points, bits), (other_points, other_bits) = (detector.detectAndCompute(i, None) for i in (left, right))
    if bits is None or other_bits is None:
        return np.empty((0, 2)), np.empty((0, 2))
    found = cv2.BFMatcher(cv2.NORM_HAMMING, crossCheck=True).match(bits, other_bits)
    near = [match for match in found if match.distance <= DISTANCE_MAX]
    here = np.array([points[match.queryIdx].pt for match in near], dtype=np.float64).reshape(-1, 2)
    there = np.array([other_points[match.trainIdx].pt for match in near], dtype=np.float64).reshape(-1, 2)
    kept = np.abs(here[:, 1] - there[:, 1]) < ROWS_MAX
    return here[kept], there[kept]
