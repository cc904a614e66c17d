"""What one writes in an afternoon: features of the taught pair in space, matched to the left image of now, PnP."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any, NamedTuple

import cv2
import numpy as np
from numpy.typing import NDArray

from scene_simulator.corridor.stereo_rig import StereoRig as Cameras
from shirube_core.geometry import SE2, gravity_aligned_camera
from stereo_landmark.core.stereo import StereoRig

RATIO = 0.8  # Lowe's, of the best match to the second best
ROW_TOLERANCE = 1.5
DISPARITY_MIN = 2.0
RANSAC: dict[str, Any] = {
    'iterationsCount': 1000,
    'reprojectionError': 2.0,
    'confidence': 0.999,
    'flags': cv2.SOLVEPNP_EPNP,
}
INLIERS_MIN = 10
FEATURES = 2000


def product_rig(cameras: Cameras) -> StereoRig:
    """Return the simulator's rectified cameras as those of stereo_landmark."""
    return StereoRig(cameras.left.intrinsics, cameras.right.intrinsics, cameras.baseline, cameras.mount)


class Features(NamedTuple):
    """Pixels of an image's features, shape (n, 2), and descriptors, shape (n, d): bytes of ORB or floats of SIFT."""

    pixels: NDArray[np.float64]
    descriptors: NDArray[np.generic]


class TaughtFeatures(NamedTuple):
    """Features of a taught pair: points in the left optical frame, shape (n, 3) [m], pixels in the left image, shape
    (n, 2), and descriptors, shape (n, d).
    """

    points: NDArray[np.float64]
    pixels: NDArray[np.float64]
    descriptors: NDArray[np.generic]

    def select(self, chosen: NDArray[np.bool_]) -> TaughtFeatures:
        """Return the features of a mask, shape (n,)."""
        return TaughtFeatures(self.points[chosen], self.pixels[chosen], self.descriptors[chosen])


class FeaturePipeline:
    """ORB or SIFT, by its name, with stereo of rectified cameras and PnP."""

    def __init__(self, name: str, rig: StereoRig) -> None:
        self.name = name
        makers: dict[str, Callable[..., cv2.Feature2D]] = {'ORB': cv2.ORB.create, 'SIFT': cv2.SIFT.create}
        self._detector = makers[name](nfeatures=FEATURES)
        self._norm = cv2.NORM_HAMMING if name == 'ORB' else cv2.NORM_L2
        self.rig = rig

    def features(self, image: NDArray[np.uint8]) -> Features:
        """Return the features of an image, shape (h, w)."""
        found, descriptors = self._detector.detectAndCompute(image, None)
        pixels = np.array([point.pt for point in found], dtype=np.float64).reshape(-1, 2)
        return Features(pixels, np.empty((0, 1), np.float32) if descriptors is None else descriptors)

    def teach(self, pair: tuple[NDArray[np.uint8], NDArray[np.uint8]]) -> TaughtFeatures:
        """Return the features that both images show, in space."""
        left, right = (self.features(image) for image in pair)
        matches = self._matches(left.descriptors, right.descriptors)
        here, there = left.pixels[matches[:, 0]], right.pixels[matches[:, 1]]
        disparity = here[:, 0] - self.rig.left.cx - (there[:, 0] - self.rig.right.cx)
        good = (np.abs(here[:, 1] - there[:, 1]) <= ROW_TOLERANCE) & (disparity >= DISPARITY_MIN)
        depth = self.rig.left.fx * self.rig.baseline / disparity[good]
        points = self.rig.left.rays_from_pixels(here[good]) * depth[:, None]
        return TaughtFeatures(points, here[good], left.descriptors[matches[good, 0]])

    def locate(self, taught: TaughtFeatures, now: Features) -> SE2 | None:
        """Return the robot's pose in the taught frame, None without enough inliers."""
        motion = self.motion(taught, now)
        return None if motion is None else planar_displacement(*motion, self.rig)

    def motion(self, taught: TaughtFeatures, now: Features) -> tuple[NDArray[np.float64], NDArray[np.float64]] | None:
        """Return rotation (3, 3) and shift (3,) [m] of points from the left optical frame then to the one of now."""
        matches = self._matches(taught.descriptors, now.descriptors)
        if len(matches) < INLIERS_MIN:
            return None
        points, pixels = taught.points[matches[:, 0]], now.pixels[matches[:, 1]]
        matrix = self.rig.left.matrix
        is_found, *motion, inliers = cv2.solvePnPRansac(points, pixels, matrix, None, **RANSAC)
        if not is_found or inliers is None or len(inliers) < INLIERS_MIN:
            return None
        kept = inliers.ravel()
        turn, shift = cv2.solvePnPRefineLM(points[kept], pixels[kept], matrix, None, *motion)
        return np.asarray(cv2.Rodrigues(turn)[0]), np.asarray(shift).ravel()

    def _matches(self, here: NDArray[np.generic], there: NDArray[np.generic]) -> NDArray[np.int64]:
        """Return numbers of features that match, shape (m, 2)."""
        if len(here) < 2 or len(there) < 2:
            return np.empty((0, 2), dtype=np.int64)
        pairs = cv2.BFMatcher(self._norm).knnMatch(here, there, k=2)
        good = [(m.queryIdx, m.trainIdx) for m, n in pairs if m.distance < RATIO * n.distance]
        return np.array(good, dtype=np.int64).reshape(-1, 2)


def planar_displacement(R_now_then: NDArray[np.float64], shift_now: NDArray[np.float64], rig: StereoRig) -> SE2:
    """Return the robot's pose in the taught frame of a level robot; arguments as of `level_displacement`."""
    x, y, _, yaw = level_displacement(R_now_then, shift_now, (0.0, 0.0), rig).tolist()
    return SE2(x, y, yaw)


def level_displacement(
    R_now_then: NDArray[np.float64], shift_now: NDArray[np.float64], tilt_then: tuple[float, float], rig: StereoRig
) -> NDArray[np.float64]:
    """Return x, y, z [m] and yaw [rad] of the base in the taught level frame, shape (4,), from the camera's motion.

    Args:
        R_now_then: shape (3, 3), takes points of the taught optical frame to the one of now.
        shift_now: shape (3,), with ``x_now = R x_then + shift`` [m].
        tilt_then: roll and pitch of the base when it was taught [rad].
        rig: how the camera sits on the robot.
    """
    camera = gravity_aligned_camera(rig.mount, *tilt_then)
    R_place_optical = camera.rotation @ R_now_then.T
    eye = camera.position - R_place_optical @ shift_now
    R_place_base = R_place_optical @ rig.mount.rotation.T
    position = eye - R_place_base @ np.array(rig.mount.xyz)
    return np.array([*position, np.arctan2(R_place_base[1, 0], R_place_base[0, 0])])
