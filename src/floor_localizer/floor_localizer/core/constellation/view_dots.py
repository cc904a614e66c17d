"""The dots of one view, prepared for the search."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from floor_localizer.core.constellation.neighbours import sort_neighbours

# Number of neighbours per dot: enough for the longest baseline of a constellation and for the pair search.
_MAX_NEIGHBOURS = 32


class ViewDots(NamedTuple):
    """The dots of one view, prepared for the search.

    Attributes:
        points: shape (n, 2), dots on the floor in the base frame, for the camera as mounted [m].
        z: shape (n,) complex, the same points.
        neighbours: shape (n, m), neighbours of each dot, nearest first.
        sigma: standard deviation of a dot's position along each axis, of image and map together [m].
        tilt_distortion: shift of a dot by tilt over its squared distance from the dots fitted so far [1/m].
        scale_tolerance: maximum relative error of the camera's height.
        density: density of the map's dots on the occupied floor [1/m^2].
    """

    points: NDArray[np.float64]
    z: NDArray[np.complex128]
    neighbours: NDArray[np.int64]
    sigma: float
    tilt_distortion: float
    scale_tolerance: float
    density: float


def make_view(
    points: NDArray[np.float64], sigma: float, tilt_distortion: float, scale_tolerance: float, density: float
) -> ViewDots:
    """Return the view of dots on the floor at ``points``, shape (n, 2) [m]; other arguments as in `ViewDots`."""
    z = points[:, 0] + 1j * points[:, 1]
    return ViewDots(
        points, z, sort_neighbours(points, _MAX_NEIGHBOURS), sigma, tilt_distortion, scale_tolerance, density
    )


def mirror_view(view: ViewDots) -> ViewDots:
    """Return the mirror image of a view, left and right swapped."""
    return view._replace(points=view.points * (1.0, -1.0), z=view.z.conj())
