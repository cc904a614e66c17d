"""Compile the numba kernels: run all of them once on a small synthetic floor, before the first real image.

Compilation takes about a minute at the very first start; afterwards numba loads the kernels from its cache on disk.
"""

import math

import numpy as np

from floor_localizer.core.arrays import Floats
from floor_localizer.core.constellation.indexed_map import index_map
from floor_localizer.core.dot_extraction.detector import DotDetector
from floor_localizer.core.dots import DetectedDots, DotMap
from floor_localizer.core.fix import PosePrior
from floor_localizer.core.localizer import FloorLocalizer
from shirube_core.geometry import SE2, CameraMount, PinholeCamera

_DOTS = 200
_SIDE = 0.2  # side of the synthetic floor [m]
_HALF_VIEW = 0.04  # half the width of the view [m]
_POSE = SE2(_SIDE / 2.0, _SIDE / 2.0, 0.3)


def compile_kernels() -> None:
    """Extract dots, index a floor, and locate views."""
    _extract_dots()
    _search()


def _extract_dots() -> None:
    """Extract dots from a grey and a colour image."""
    image = np.full((235, 235), 200, dtype=np.uint8)
    for u, v in _camera_view()[2].astype(int):
        image[max(v - 3, 0) : v + 3, max(u - 3, 0) : u + 3] = 40
    detector = DotDetector()
    detector.detect(image)
    detector.detect(np.dstack([image, image, image]))


def _search() -> None:
    """Index a floor, locate views with and without a prior."""
    floor, camera, pixels = _camera_view()
    indexed = index_map(floor)
    localizer = FloorLocalizer(indexed, CameraMount())
    matching = _as_dots(pixels)
    unmatched = _as_dots(np.random.default_rng(1).uniform(0.0, 234.0, (20, 2)))
    localizer.locate_dots(matching, camera)
    localizer.locate_dots(matching, camera, PosePrior(_POSE, 0.01, 0.1))
    localizer.locate_dots(unmatched, camera)


def _camera_view() -> tuple[DotMap, PinholeCamera, Floats]:
    """Return a synthetic floor, a camera and the floor's dots in its image, shape (n, 2) [px]."""
    floor = np.random.default_rng(0).uniform(0.0, _SIDE, (_DOTS, 2))
    points = _POSE.inverse().transform(floor)
    points = points[(np.abs(points) < _HALF_VIEW).all(axis=1)]
    camera = PinholeCamera(235, 235, 339.44, 339.44, 117.0, 117.0)
    pixels = camera.pixels_from_points(CameraMount().camera_points_from_floor(points))
    return DotMap(floor, np.full(_DOTS, math.nan)), camera, pixels


def _as_dots(pixels: Floats) -> DetectedDots:
    return DetectedDots(pixels, np.full(len(pixels), 6.0), np.full(len(pixels), 0.1))
