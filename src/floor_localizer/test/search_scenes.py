"""Views in the format of the searches, with the true similarity."""

import cmath

import numpy as np
from floor_views import CAMERA, MOUNT, View, pose_over, see
from numpy.typing import NDArray

from floor_localizer.core.constellation.acceptance import SearchState, new_search
from floor_localizer.core.constellation.indexed_map import IndexedMap
from floor_localizer.core.dots import DotMap, ViewDots, sort_neighbours
from shirube_core.geometry import SE2

SIGMA = 8e-5


def view_dots(points: NDArray[np.float64], density: float, sigma: float = SIGMA) -> ViewDots:
    return ViewDots(points, points @ (1.0, 1j), sort_neighbours(points, 32), sigma, 0.27, 0.05, density)


def scene(floor: DotMap, indexed: IndexedMap, seed: int, **disturbance: float) -> tuple[SE2, View, ViewDots]:
    rng = np.random.default_rng(seed)
    pose = pose_over(rng)
    view = see(floor, pose, rng, **disturbance)
    points = MOUNT.floor_points_from_rays(CAMERA.rays_from_pixels(view.dots.pixels))
    return pose, view, view_dots(points, indexed.density)


def similarity(pose: SE2) -> tuple[complex, complex]:
    return cmath.exp(1j * pose.yaw), complex(pose.x, pose.y)


def new_search_for(view: ViewDots, indexed: IndexedMap) -> SearchState:
    return new_search(len(view.z), float(len(indexed.grid.points)), 1e-3, 0.25)
