"""Runs every compiled kernel once on a tiny made-up floor, so that the first real image does not wait for a
compiler.

The kernels are compiled at their first use, which takes about a minute, and kept on disk from then on.
"""

from __future__ import annotations

import math

import numpy as np

from floor_localizer.core.constellation.indexed_map import index_map
from floor_localizer.core.detected_dots import DetectedDots
from floor_localizer.core.dot_map import DotMap
from floor_localizer.core.fix import PosePrior
from floor_localizer.core.localizer import FloorLocalizer
from shirube_geometry import CameraMount, PinholeCamera, PlanarPose

_DOTS = 200
_SIDE = 0.2  # of the made-up floor [m]
_SEEN = 0.04  # half the width of the view [m]


def warm_up() -> None:
    """Index a floor, extract dots from an image of nothing much, locate views with and without a prior."""
    rng = np.random.default_rng(0)
    floor = index_map(DotMap(rng.uniform(0.0, _SIDE, (_DOTS, 2)), np.full(_DOTS, math.nan)))
    mount, camera = CameraMount(), PinholeCamera(235, 235, 339.44, 339.44, 117.0, 117.0)
    localizer = FloorLocalizer(floor, mount)
    pose = PlanarPose(_SIDE / 2.0, _SIDE / 2.0, 0.3)
    points = pose.inverse().transform(floor.grid.points)
    points = points[(np.abs(points) < _SEEN).all(axis=1)]
    pixels = camera.pixels_from_points(mount.camera_points_from_floor(points))
    known = _as_dots(pixels)
    strange = _as_dots(rng.uniform(0.0, 234.0, (20, 2)))
    localizer.locate_dots(known, camera)
    localizer.locate_dots(known, camera, PosePrior(pose, 0.01, 0.1))
    localizer.locate_dots(strange, camera)
    image = np.full((235, 235), 200, dtype=np.uint8)
    for u, v in pixels.astype(int):
        image[max(v - 3, 0) : v + 3, max(u - 3, 0) : u + 3] = 40
    localizer.detect(image)
    localizer.detect(np.dstack([image, image, image]))


def _as_dots(pixels: np.ndarray) -> DetectedDots:
    return DetectedDots(pixels, np.full(len(pixels), 6.0), np.full(len(pixels), 0.1))


if __name__ == '__main__':
    warm_up()
