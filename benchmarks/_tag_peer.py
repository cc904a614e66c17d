"""One AprilTag of known size: OpenCV's detector with sub-pixel corners, from one image or from both."""

from __future__ import annotations

import cv2
import numpy as np
from _landmark_views import SIDE
from _stereo_peers import planar_displacement
from _stereo_scenes import CAMERAS, Pair
from numpy.typing import NDArray

from shirube_core.geometry import SE2
from stereo_landmark.core.place.place_locator import PlaceFix, PlaceLocator
from stereo_landmark.core.settings import PlaceSettings
from stereo_landmark.core.stereo import StereoPoints

ID = 7
CELLS = 8
CORNER_SIGMA = 0.1
"""Stated of a corner [px]; it is the same for all, so that the fit does not depend on it."""
NAMES = tuple(f'corner {i}' for i in range(4))
SQUARE = 0.5 * SIDE * np.array([[-1.0, 1.0, 0.0], [1.0, 1.0, 0.0], [1.0, -1.0, 0.0], [-1.0, -1.0, 0.0]])


class TagPeer:
    """Finds the tag of the family 36h11."""

    def __init__(self) -> None:
        self._dictionary = cv2.aruco.getPredefinedDictionary(cv2.aruco.DICT_APRILTAG_36h11)
        parameters = cv2.aruco.DetectorParameters()
        parameters.cornerRefinementMethod = cv2.aruco.CORNER_REFINE_SUBPIX
        self._detector = cv2.aruco.ArucoDetector(self._dictionary, parameters)
        settings = PlaceSettings(pixel_sigma=0.0, tilt_sigma=0.0, gate_sigmas=20.0)
        self._locator = PlaceLocator(CAMERAS, settings)

    def cells(self) -> NDArray[np.bool_]:
        """Return the tag with its black border, shape (CELLS, CELLS), true for white."""
        return np.asarray(cv2.aruco.generateImageMarker(self._dictionary, ID, CELLS) > 127, dtype=np.bool_)

    def corners(self, image: NDArray[np.uint8]) -> NDArray[np.float64] | None:
        """Return the tag's corners, shape (4, 2) [px]; None if it is not found."""
        corners, ids, _ = self._detector.detectMarkers(image)
        if ids is None or ID not in np.ravel(ids):
            return None
        found = corners[np.ravel(ids).tolist().index(ID)]
        return np.asarray(found, dtype=np.float64).reshape(4, 2)

    def locate_from_left(self, then: Pair, now: Pair) -> SE2 | None:
        """Return the displacement between the left images of two pairs, in six degrees of freedom each."""
        poses = []
        for image in (then[0], now[0]):
            corners = self.corners(image)
            if corners is None:
                return None
            matrix = CAMERAS.left.matrix
            is_found, *motion = cv2.solvePnP(SQUARE, corners, matrix, None, flags=cv2.SOLVEPNP_IPPE_SQUARE)
            if not is_found:
                return None
            turn, shift = cv2.solvePnPRefineLM(SQUARE, corners, matrix, None, *motion)
            poses.append((cv2.Rodrigues(turn)[0], shift.ravel()))
        (R_then, shift_then), (R_now, shift_now) = poses
        R_now_then = R_now @ R_then.T
        return planar_displacement(R_now_then, shift_now - R_now_then @ shift_then, CAMERAS)

    def locate_from_both(self, then: Pair, now: Pair) -> SE2 | None:
        """Return the displacement that explains the corners in all four images best, on a level floor."""
        seen = []
        for left, right in (then, now):
            here, there = self.corners(left), self.corners(right)
            if here is None or there is None:
                return None
            noise = np.tile(CORNER_SIGMA**2 * np.eye(4), (4, 1, 1))
            seen.append(StereoPoints(NAMES, np.hstack([here, there]), noise))
        fix = self._locator.locate(seen[1], self._locator.spatial_points(seen[0]))
        return fix.T_place_base if isinstance(fix, PlaceFix) else None
