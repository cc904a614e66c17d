"""What is written in an afternoon: ORB or SIFT features, stereo and PnP, between two stereo pairs."""

from __future__ import annotations

import cv2
import numpy as np
from _real_pairs import Moment
from numpy.typing import NDArray
from scipy.spatial.transform import Rotation

from shirube_geometry import level_camera
from stereo_landmark.core.place.stereo_rig import StereoRig

FEATURES = ('ORB', 'SIFT')
ROWS_APART = 1.5
"""[px]"""
DISPARITY_MIN = 3.0
"""[px]"""
RATIO = 0.8
"""Lowe's: the best match must be so much better than the second."""
PNP_ERROR = 2.0
"""[px]"""
INLIERS_MIN = 10


def peer_displacement(
    method: str, taught: Moment, now: Moment, rig: StereoRig, seed: int
) -> NDArray[np.float64] | None:
    """Return x, y, z [m] and yaw [rad] of the base in the taught level frame, shape (4,); None for no pose.

    Args:
        method: 'ORB' or 'SIFT'.
        taught: the pair whose features are triangulated; its tilt levels the frame.
        now: its left image is matched with the left one of the taught pair.
        rig: the cameras.
        seed: of the random choices of RANSAC.
    """
    detector = cv2.ORB.create(2000) if method == 'ORB' else cv2.SIFT.create()
    matcher = cv2.BFMatcher(cv2.NORM_HAMMING if method == 'ORB' else cv2.NORM_L2)
    (left, left_words), (right, right_words), (here, here_words) = (
        detector.detectAndCompute(image, None) for image in (taught.left, taught.right, now.left)
    )
    points, words = [], []
    for i, j in _matches(matcher, left_words, right_words):
        (u, v), (u_right, v_right) = left[i].pt, right[j].pt
        disparity = u - rig.left.cx - (u_right - rig.right.cx)
        if abs(v - v_right) <= ROWS_APART and disparity >= DISPARITY_MIN:
            z = rig.left.fx * rig.baseline / disparity
            points.append(((u - rig.left.cx) / rig.left.fx * z, (v - rig.left.cy) / rig.left.fy * z, z))
            words.append(left_words[i])
    pairs = _matches(matcher, np.array(words), here_words) if len(words) > 1 else []
    if len(pairs) < INLIERS_MIN:
        return None
    spatial = np.array([points[i] for i, _ in pairs])
    pixels = np.array([here[j].pt for _, j in pairs])
    pose = _pnp(spatial, pixels, rig, seed)
    return None if pose is None else _of_base(*pose, taught, rig)


def _matches(
    matcher: cv2.BFMatcher, one: NDArray[np.generic], other: NDArray[np.generic]
) -> list[tuple[int, int]]:
    """Return mutual best matches that are clearly better than the second best."""
    nearest = {m.queryIdx: m.trainIdx for (m,) in matcher.knnMatch(other, one, k=1)}
    return [
        (best.queryIdx, best.trainIdx)
        for best, second in matcher.knnMatch(one, other, k=2)
        if best.distance < RATIO * second.distance and nearest[best.trainIdx] == best.queryIdx
    ]


def _pnp(
    points: NDArray[np.float64], pixels: NDArray[np.float64], rig: StereoRig, seed: int
) -> tuple[NDArray[np.float64], NDArray[np.float64]] | None:
    """Return rotation (3, 3) and shift (3,) from the left optical frame then to now, refined on all inliers."""
    K = rig.left.matrix
    cv2.setRNGSeed(seed)
    found, turn, shift, inliers = cv2.solvePnPRansac(
        points, pixels, K, None, iterationsCount=1000, reprojectionError=PNP_ERROR, confidence=0.999
    )
    if not found or inliers is None or len(inliers) < INLIERS_MIN:
        return None
    kept = inliers.ravel()
    turn, shift = cv2.solvePnPRefineLM(points[kept], pixels[kept], K, None, turn, shift)
    return np.asarray(cv2.Rodrigues(turn)[0]), np.asarray(shift).ravel()


def _of_base(
    R_now_then: NDArray[np.float64], shift: NDArray[np.float64], taught: Moment, rig: StereoRig
) -> NDArray[np.float64]:
    camera = level_camera(rig.mount, *taught.tilt)
    R_place_optical = camera.rotation @ R_now_then.T
    eye = camera.position - R_place_optical @ shift
    R_place_base = R_place_optical @ rig.mount.rotation.T
    position = eye - R_place_base @ np.array(rig.mount.xyz)
    yaw = Rotation.from_matrix(R_place_base).as_euler('xyz')[2]
    return np.array([*position, yaw])
