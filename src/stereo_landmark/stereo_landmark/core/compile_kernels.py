"""Compiles all numba kernels by teaching and localizing a drawn wall, so that no real pair waits for the compiler."""

import math

import cv2
import numpy as np

from shirube_core.geometry import CameraMount, PinholeCamera
from stereo_landmark.core.arrays import GreyImage
from stereo_landmark.core.edges.edges import thin
from stereo_landmark.core.landmark_localizer import LandmarkLocalizer
from stereo_landmark.core.primitives.primitive import ImageProcessing, Primitive, PrimitiveKind
from stereo_landmark.core.procedure.stereo_view import StereoView, detect_scene
from stereo_landmark.core.stereo import StereoRig
from stereo_landmark.core.teaching.primitive_selection import TargetSelection
from stereo_landmark.core.teaching.teacher import Teacher

_CAMERA = PinholeCamera(320, 240, 300.0, 300.0, 159.5, 119.5)
_MOUNT = CameraMount((0.0, 0.0, 1.0), (-math.pi / 2.0, 0.0, -math.pi / 2.0))
_RIG = StereoRig(_CAMERA, _CAMERA, 0.2, _MOUNT)
_DISPARITY = 20
"""Disparity of the wall [px]."""


def compile_kernels() -> None:
    """Run every numba kernel from the grey images to the displacement."""
    images = _draw_wall(0), _draw_wall(_DISPARITY)
    processing = ImageProcessing()
    view = StereoView(detect_scene(images[0], processing), detect_scene(images[1], processing), _RIG)
    teacher = Teacher(view, processing)
    parts: dict[str, Primitive] = {}
    for kind in PrimitiveKind:
        for primitive in view.left.kinds[kind].primitives:
            if kind.value not in parts and teacher.can_measure(primitive):
                parts[kind.value] = primitive
    place = teacher.teach('wall', [TargetSelection('things', parts)])
    LandmarkLocalizer([place]).locate(*images)
    # Only the thinning control of a taught place reaches this one.
    thin(np.zeros((3, 3), dtype=np.bool_), 1)


def _draw_wall(shift: int) -> GreyImage:
    """Draw plates, discs and a slot, all shifted to the left by a disparity [px], shape (240, 320)."""
    picture = np.full((_CAMERA.height, _CAMERA.width), 120, dtype=np.uint8)
    for left, top, right, bottom, level in ((60, 40, 130, 90, 40), (220, 30, 290, 110, 210), (80, 190, 260, 198, 30)):
        cv2.rectangle(picture, (left - shift, top), (right - shift, bottom), level, cv2.FILLED)
    for x, y, radius, level in ((180, 80, 22, 230), (90, 145, 16, 30)):
        cv2.circle(picture, (x - shift, y), radius, level, cv2.FILLED, cv2.LINE_AA)
    return np.asarray(cv2.GaussianBlur(picture, (0, 0), 0.8), dtype=np.uint8)


if __name__ == '__main__':
    compile_kernels()
