"""Views of a simulated floor on the paper's conditions (Fukase and Kanamori, 3.3.1 to 3.3.4).

A floor of 1800 x 9450 mm with 91 582 dots, uniformly random; a camera of 235 x 235 pixels that sees
90 x 90 mm; centroids with a normal error of 1 px along each axis. What the paper leaves open is settled so:

- Its 1209 places on a grid of 112.5 mm cannot be: 16 x 84 would fill the floor. Here they are a grid of
  13 x 93, evenly spaced (139 and 101 mm) so that a view turned anyhow stays on the floor.
- The camera's heading is random, as the method claims to find it.
- Rates of missing and spurious dots are relative to the floor's dots in view, rounded to whole dots (halves
  to even). Spurious dots are uniformly random in the view. The centroid error comes last and may carry a dot
  over the border.
"""

import math
from collections.abc import Iterator
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray
from scipy.spatial import KDTree

from shirube_core.geometry import SE2, CameraMount, PinholeCamera

FLOOR_SIZE = (1.8, 9.45)
FLOOR_DOTS = 91582
VIEW_SIZE = 0.09
NOISE = 1.0
GRID = (13, 93)
CONDITIONS = {f'25 % missing, {100 * spurious:.0f} % spurious': (0.25, spurious) for spurious in (0.3, 0.5)}
"""Conditions of timing: rates of missing and spurious dots, by name."""
CAMERA = PinholeCamera(235, 235, 339.44, 339.44, 117.0, 117.0)
MOUNT = CameraMount()


class PaperView(NamedTuple):
    """The dots of one image and the truth about them.

    Attributes:
        pixels: shape (n, 2), centroids [px].
        T_map_view: true pose of the view; its frame is the base frame of ``MOUNT``.
        map_dots: shape (n,), the floor dot that each image dot shows, -1 for a spurious one.
    """

    pixels: NDArray[np.float64]
    T_map_view: SE2
    map_dots: NDArray[np.intp]


def paper_floor(seed: int) -> NDArray[np.float64]:
    """Return a floor's dots, shape (91582, 2), in the map frame [m]."""
    return np.random.default_rng(seed).uniform((0.0, 0.0), FLOOR_SIZE, (FLOOR_DOTS, 2))


def paper_places() -> NDArray[np.float64]:
    """Return the places of the views, shape (1209, 2), in the map frame [m]."""
    margin = VIEW_SIZE / math.sqrt(2.0)
    x, y = (np.linspace(margin, size - margin, steps) for size, steps in zip(FLOOR_SIZE, GRID, strict=True))
    return np.stack(np.meshgrid(x, y), axis=-1).reshape(-1, 2)


def spread_places(count: int) -> NDArray[np.float64]:
    """Return so many of the places, spread over all, shape (count, 2) [m]."""
    places = paper_places()
    return places[np.linspace(0, len(places) - 1, min(count, len(places))).round().astype(np.intp)]


def paper_views(
    floor: NDArray[np.float64],
    places: NDArray[np.float64],
    missing: float,
    spurious: float,
    seed: int,
    noise: float = NOISE,
    dots: tuple[int, int] | None = None,
) -> Iterator[PaperView]:
    """Yield a view for each place.

    Args:
        floor: shape (N, 2), the floor's dots [m].
        places: shape (p, 2), centres of the views [m].
        missing: dots removed, as a share of the floor's dots in view.
        spurious: dots added, as a share of the floor's dots in view.
        seed: the same seed gives the same views.
        noise: standard deviation of a centroid along each axis [px].
        dots: numbers of right (if there are as many) and of spurious dots, in place of the rates.
    """
    tree = KDTree(floor)
    for number, place in enumerate(places):
        rng = np.random.default_rng([seed, number])
        T_map_view = SE2(float(place[0]), float(place[1]), rng.uniform(-math.pi, math.pi))
        nearby = np.array(tree.query_ball_point(place, VIEW_SIZE), dtype=np.intp)
        points_view = T_map_view.inverse().transform(floor[nearby])
        pixels = CAMERA.pixels_from_points(MOUNT.camera_points_from_floor(points_view))
        visible = ((pixels > -0.5) & (pixels < CAMERA.width - 0.5)).all(axis=1)
        pixels, in_view = pixels[visible], nearby[visible]
        lost, added = round(missing * len(in_view)), round(spurious * len(in_view))
        if dots is not None:
            lost, added = max(len(in_view) - dots[0], 0), dots[1]
        kept = rng.permutation(len(in_view))[lost:]
        dirt = rng.uniform(-0.5, CAMERA.width - 0.5, (added, 2))
        shown = np.vstack([pixels[kept], dirt])
        map_dots = np.concatenate([in_view[kept], np.full(len(dirt), -1)])
        yield PaperView(shown + rng.normal(0.0, noise, shown.shape), T_map_view, map_dots)
