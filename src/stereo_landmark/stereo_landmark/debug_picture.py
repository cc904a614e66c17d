"""Debug image: the detected targets and the pose, drawn into the left image."""

from __future__ import annotations

import cv2
import numpy as np
from numpy.typing import NDArray

from stereo_landmark.core.landmark_fix import LandmarkFix, NoLandmarkFix
from stereo_landmark.core.pair.pair_localizer import LocatedPair
from stereo_landmark.core.procedure.target_detection import TargetDetection

_USED, _UNUSED, _TEXT_COLOUR = (60, 220, 60), (0, 200, 255), (255, 255, 255)
_SUBPIXEL_BITS = 4
_CROSS_ARM = 6.0
"""Arm length of the cross on a point [px]."""
_TEXT_SCALE = 0.45


def debug_picture(located: LocatedPair) -> NDArray[np.uint8]:
    """Draw the points used for the pose (green), the other detected points (yellow) and the pose or failure reason.

    Returns:
        BGR image, shape (h, w, 3).
    """
    picture = np.array(cv2.cvtColor(located.left, cv2.COLOR_GRAY2BGR), dtype=np.uint8)
    result = located.result
    used = result.displacement.names if isinstance(result, LandmarkFix) else ()
    for detection in result.detections:
        if not isinstance(detection, TargetDetection):
            continue
        for name, pixels in zip(detection.points.names, detection.points.pixels, strict=True):
            colour = _USED if name in used else _UNUSED
            _draw_cross(picture, pixels[:2], colour)
        if len(detection.points):
            u, v = np.rint(detection.points.pixels[0, :2]).astype(int)
            _draw_text(picture, detection.target, (int(u) + 8, int(v) - 8), _USED)
    _draw_text(picture, _headline(result), (4, 16), _TEXT_COLOUR)
    return picture


def _headline(result: LandmarkFix | NoLandmarkFix) -> str:
    if isinstance(result, NoLandmarkFix):
        return f'no fix: {result.reason}'
    pose = result.displacement.T_place_base
    return f'{result.place.name}: {pose.x:.3f} {pose.y:.3f} m {pose.yaw:.3f} rad'


def _draw_cross(picture: NDArray[np.uint8], place: NDArray[np.float64], colour: tuple[int, int, int]) -> None:
    for step in (np.array([_CROSS_ARM, 0.0]), np.array([0.0, _CROSS_ARM])):
        begin, end = (np.rint((place + shift) * (1 << _SUBPIXEL_BITS)).astype(int) for shift in (-step, step))
        cv2.line(picture, begin.tolist(), end.tolist(), colour, 1, cv2.LINE_AA, _SUBPIXEL_BITS)


def _draw_text(
    picture: NDArray[np.uint8], text: str, place: tuple[int, int], colour: tuple[int, int, int]
) -> None:
    for shade, width in (((0, 0, 0), 3), (colour, 1)):
        cv2.putText(picture, text, place, cv2.FONT_HERSHEY_SIMPLEX, _TEXT_SCALE, shade, width, cv2.LINE_AA)
