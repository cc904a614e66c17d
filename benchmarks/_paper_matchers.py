"""The matchers that the paper's tables compare, behind one signature: pixels in, pose or reason out."""

import math
from collections.abc import Callable
from typing import NamedTuple

import numpy as np
from _paper_views import CAMERA, MOUNT, NOISE
from numpy.typing import NDArray

from floor_localizer.core.constellation.acceptance import new_search
from floor_localizer.core.constellation.constellation_search import search_constellations
from floor_localizer.core.constellation.indexed_map import IndexedMap, index_map
from floor_localizer.core.dots import DetectedDots, DotMap, ViewDots, make_view
from floor_localizer.core.fix import Fix
from floor_localizer.core.localizer import FloorLocalizer
from floor_localizer.core.pole_star.pole_star_matcher import NoPose, PoleStarMatcher
from floor_localizer.core.settings import LocalizerSettings, PoleStarSettings
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


Candidates = Callable[[NDArray[np.float64]], list[tuple[SE2, float]]]
"""From pixels, shape (n, 2), to poses, right and wrong, with their match rates."""


def pole_star_candidates(floor: NDArray[np.float64]) -> Candidates:
    """Return what finds the congruent poses on a floor, shape (N, 2) [m], whatever their match rate."""
    matcher = PoleStarMatcher(floor, PoleStarSettings())

    def find(pixels: NDArray[np.float64]) -> list[tuple[SE2, float]]:
        poses = matcher.congruent_poses(MOUNT.floor_points_from_rays(CAMERA.rays_from_pixels(pixels)))
        return [(pose.T_map_view, pose.match_rate) for pose in poses]

    return find


def view_dots(pixels: NDArray[np.float64], density: float, noise: float, settings: LocalizerSettings) -> ViewDots:
    """Return pixels, shape (n, 2), of this noise [px] as the searches take them."""
    return make_view(
        MOUNT.floor_points_from_rays(CAMERA.rays_from_pixels(pixels)),
        noise * MOUNT.xyz[2] / CAMERA.fx,
        settings.tilt_tolerance / MOUNT.xyz[2],
        settings.scale_tolerance,
        density,
    )


def constellation_candidates(points: NDArray[np.float64]) -> Candidates:
    """Return what finds the two best poses by constellations on a floor, shape (N, 2) [m], accepted or not."""
    floor, settings = indexed(points), LocalizerSettings()

    def find(pixels: NDArray[np.float64]) -> list[tuple[SE2, float]]:
        view = view_dots(pixels, floor.density, NOISE, settings)
        # A threshold of no alignments at all: the search goes on after the right pose.
        search = new_search(len(pixels), len(points), 1.0, 0.0)._replace(log_threshold=-math.inf)
        search_constellations(floor.grid, floor.index, view, search, settings.cells_max // 10)
        poses = (pose for pose in (search.best, search.runner_up) if math.isfinite(pose.log_chance))
        return [(pose.pose, pose.matched / len(pixels)) for pose in poses]

    return find


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
