"""Printed markers in the lamps' places: ArUco 4x4 and AprilTag 16h5 of OpenCV, as large as the lamps.

They are as bright over black as the lamps over the ceiling, which needs light in the room; lamps bring their own.
"""

import math

import cv2
import numpy as np
from _lamp_pictures import BLUR, FINE, Light, finish_picture
from _lamp_room import CAMERA, IDS, LAMP_RADIUS, View
from numpy.typing import NDArray

SIDE = 2.0 * LAMP_RADIUS  # of a marker in the image [px]: 6.5 cm
PLATE = 1.5  # side of the white plate over that of the marker
CELL_PIXELS = 16
FAMILIES = {'ArUco 4x4': 'DICT_4X4_50', 'AprilTag 16h5': 'DICT_APRILTAG_16h5'}
THRESHOLD, OTSU_DEVIATION = 1.0, 1.0
"""With OpenCV's own, 7 and 5 grey levels, nothing is found at a contrast of 7; these find the most of 1 to 7."""


def is_available() -> bool:
    """Return whether this OpenCV has markers."""
    return hasattr(cv2, 'aruco') and hasattr(cv2.aruco, 'ArucoDetector')


class Markers:
    """One family of markers: draws them and finds them."""

    def __init__(self, family: str, *, sensitive: bool) -> None:
        """Take the name of a family, and whether dim markers are wanted, which takes longer."""
        self._dictionary = cv2.aruco.getPredefinedDictionary(getattr(cv2.aruco, FAMILIES[family]))
        parameters = cv2.aruco.DetectorParameters()
        if sensitive:
            parameters.adaptiveThreshConstant = THRESHOLD
            parameters.minOtsuStdDev = OTSU_DEVIATION
        parameters.cornerRefinementMethod = cv2.aruco.CORNER_REFINE_SUBPIX
        self._detector = cv2.aruco.ArucoDetector(self._dictionary, parameters)

    def picture(self, view: View, light: Light, rng: np.random.Generator) -> NDArray[np.uint8]:
        """Return an image with a marker in the place of each visible lamp."""
        plates = np.zeros((CAMERA.height, CAMERA.width))
        for id_, place in zip(IDS[view.visible], view.pixels[view.visible], strict=True):
            self._add_plate(plates, int(id_), place, view.pose.yaw)
        return finish_picture(plates, light, rng)

    def find(self, image: NDArray[np.uint8]) -> tuple[NDArray[np.int64], NDArray[np.float64], int]:
        """Return the lamps' ids in an image, shape (n,), the centres, shape (n, 2) [px], and how many others are."""
        corners, ids, _ = self._detector.detectMarkers(image)
        found = np.array([] if ids is None else ids, dtype=np.int64).ravel()
        centres = np.array([each.reshape(4, 2).mean(axis=0) for each in corners], dtype=np.float64).reshape(-1, 2)
        known = np.isin(found, IDS)
        return found[known], centres[known], int((~known).sum())

    def _add_plate(self, plates: NDArray[np.float64], id_: int, place: NDArray[np.float64], yaw: float) -> None:
        pattern = cv2.aruco.generateImageMarker(self._dictionary, id_, 6 * CELL_PIXELS)
        margin = round(0.5 * (PLATE - 1.0) * len(pattern))
        plate = np.pad(pattern.astype(np.float64) / 255.0, margin, constant_values=1.0)
        reach = math.ceil(0.75 * PLATE * SIDE) + 2
        left, top = (int(value) - reach for value in place)
        scale = FINE * SIDE / len(pattern)
        cos, sin = scale * math.cos(yaw), scale * math.sin(yaw)
        # Centres of pixels: of the fine patch, of the image and of the plate.
        middle = (place - (left, top) + 0.5) * FINE - 0.5
        half = 0.5 * (len(plate) - 1)
        shift = middle - np.array([cos * half - sin * half, sin * half + cos * half])
        size = 2 * reach + 1
        fine = cv2.warpAffine(
            plate,
            np.array([[cos, -sin, shift[0]], [sin, cos, shift[1]]]),
            (size * FINE, size * FINE),
            flags=cv2.INTER_LINEAR,
        )
        fine = cv2.GaussianBlur(fine, (0, 0), BLUR * FINE)
        patch = fine.reshape(size, FINE, size, FINE).mean(axis=(1, 3))
        rows = slice(max(top, 0), min(top + size, CAMERA.height))
        columns = slice(max(left, 0), min(left + size, CAMERA.width))
        plates[rows, columns] += patch[rows.start - top : rows.stop - top, columns.start - left : columns.stop - left]
