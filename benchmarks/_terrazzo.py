"""Views cut from one picture of terrazzo at known places (terrazzo018 of ambientCG, CC0)."""

from __future__ import annotations

import math
from typing import NamedTuple

import cv2
import numpy as np
from numpy.typing import NDArray

from floor_localizer.core.dot_extraction.detector import DotDetector
from floor_localizer.core.dots import DotMap
from scene_simulator.floor.camera import PAPER_CAMERA as CAMERA
from shirube_core.geometry import SE2, CameraMount

Array = NDArray[np.float64]
Image = NDArray[np.uint8]

TERRAZZO = ('floor_terrazzo', 'terrazzo018.jpg')
MOUNT = CameraMount()
SCALE = MOUNT.xyz[2] / CAMERA.fx
"""Of the picture: 0.383 mm/px, so that 1024 px are 392 mm and a view of the default camera is 90 mm wide [m/px]."""
SCALE_ERROR = 0.02  # greatest, of a view
NOISE = 4.0  # standard deviation of a view's grey levels
GAIN = (0.6, 1.15)  # of a view's brightness
GRADIENT = 0.15  # greatest change of brightness from the middle of a view to its side


class TerrazzoView(NamedTuple):
    """An image cut from the picture, and the pose of the robot over the picture."""

    image: Image
    T_map_base: SE2


def terrazzo_map(picture: Image, detector: DotDetector) -> DotMap:
    """Return the dots that a detector finds on the whole picture; x to the right, y up, from the lower left [m]."""
    dots = detector.detect(picture)
    return DotMap(_map_points(dots.pixels, picture), dots.diameters * SCALE)


def cut_view(picture: Image, generator: np.random.Generator) -> TerrazzoView:
    """Cut a view at a random place in a random heading, with errors of scale, brightness and noise."""
    height, width = picture.shape[:2]
    reach = math.hypot(CAMERA.width, CAMERA.height) / 2.0 * (1.0 + SCALE_ERROR) + 1.0
    middle = generator.uniform(reach, np.array([width, height]) - reach)
    yaw = generator.uniform(-math.pi, math.pi)
    x, y = _map_points(middle[None], picture)[0]
    pose = SE2(float(x), float(y), yaw)
    scale = 1.0 + generator.uniform(-SCALE_ERROR, SCALE_ERROR)
    columns, rows = np.meshgrid(np.arange(CAMERA.width), np.arange(CAMERA.height))
    rays = CAMERA.rays_from_pixels(np.column_stack([columns.ravel(), rows.ravel()]))
    points = pose.transform(scale * MOUNT.floor_points_from_rays(rays))
    pixels = np.column_stack([points[:, 0] / SCALE - 0.5, height - 0.5 - points[:, 1] / SCALE])
    u, v = np.moveaxis(pixels.astype(np.float32).reshape(CAMERA.height, CAMERA.width, 2), 2, 0)
    cut = cv2.remap(picture, u, v, cv2.INTER_CUBIC).astype(np.float64)
    sides = np.stack([columns - CAMERA.cx, rows - CAMERA.cy], axis=-1) / CAMERA.cx
    light = generator.uniform(*GAIN) * (1.0 + sides @ generator.uniform(-GRADIENT, GRADIENT, 2))
    noisy = cut * light[..., None] + generator.normal(0.0, NOISE, cut.shape)
    return TerrazzoView(np.clip(np.round(noisy), 0, 255).astype(np.uint8), pose)


def _map_points(pixels: Array, picture: Image) -> Array:
    return np.column_stack([pixels[:, 0] + 0.5, picture.shape[0] - 0.5 - pixels[:, 1]]) * SCALE
