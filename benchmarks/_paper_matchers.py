"""The matchers that the paper's tables compare, behind one signature: pixels in, pose or reason out."""

from __future__ import annotations

from collections.abc import Callable
from typing import NamedTuple

import numpy as np
from _paper_views import CAMERA, MOUNT, NOISE
from numpy.typing import NDArray

from floor_localizer.core.constellation.indexed_map import IndexedMap, index_map
from floor_localizer.core.dots import DetectedDots, DotMap
from floor_localizer.core.fix import Fix
from floor_localizer.core.localizer import FloorLocalizer
from floor_localizer.core.pole_star.pole_star_matcher import NoPose, PoleStarMatcher
from floor_localizer.core.settings import PoleStarSettings
from shirube_core.geometry import SE2

DOT_DIAMETER = 0.0025


class Answer(NamedTuple):
    """What a matcher says of one view: the pose, or why there is none, in few words without numbers."""

    T_map_view: SE2 | None
    reason: str = ''


Matcher = Callable[..., Answer]
"""From pixels, shape (n, 2), and perhaps their noise [px], which only the localizer uses."""


def pole_star(floor: NDArray[np.float64]) -> Matcher:
    """Return the paper's own method on a floor, shape (N, 2) [m]."""
    matcher = PoleStarMatcher(floor, PoleStarSettings())

    def locate(pixels: NDArray[np.float64], _noise: float = NOISE) -> Answer:
        poses = matcher.congruent_poses(MOUNT.floor_points_from_rays(CAMERA.rays_from_pixels(pixels)))
        found = matcher.select_pose(poses)
        if isinstance(found, NoPose):
            return Answer(None, 'match rate too low' if poses else 'nothing congruent')
        return Answer(found.T_map_view)

    return locate


def detected(pixels: NDArray[np.float64], noise: float = NOISE) -> DetectedDots:
    """Return centroids, shape (n, 2) [px], as the detector gives them."""
    diameters = np.full(len(pixels), DOT_DIAMETER / MOUNT.xyz[2] * CAMERA.fx)
    return DetectedDots(pixels, diameters, np.full(len(pixels), noise))


def indexed(floor: NDArray[np.float64]) -> IndexedMap:
    """Return a map without diameters of a floor, shape (N, 2) [m]."""
    return index_map(DotMap(floor, np.full(len(floor), np.nan)))


def constellation(floor: IndexedMap) -> Matcher:
    """Return the suite's localizer on a map."""
    localizer = FloorLocalizer(floor, MOUNT)

    def locate(pixels: NDArray[np.float64], noise: float = NOISE) -> Answer:
        found = localizer.locate_dots(detected(pixels, noise), CAMERA)
        if isinstance(found, Fix):
            return Answer(found.T_map_base)
        return Answer(None, found.reason.value)

    return locate
