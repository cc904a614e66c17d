"""The dots of one view, made ready for the search."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from floor_localizer.core.constellation.neighbours import order_neighbours

# The largest base of a constellation and the glances of a pair stay among so many neighbours.
_NEIGHBOURS = 32


class ViewDots(NamedTuple):
    """The dots of one view, made ready for the search.

    Attributes:
        points: shape (n, 2), where the dots lie on the floor in the base frame, for the camera as mounted [m].
        z: shape (n,) complex, the same.
        nearest: shape (n, m), for each dot the others from near to far.
        sigma: standard deviation of a dot's place along each axis, in the image and in the map together [m].
        bend: shift of a dot by tilt, over the square of its distance from the dots fitted so far [1/m].
        scale_tolerance: the camera's height may be off by this share.
        density: dots of the map on a square metre where there are dots [1/m^2].
    """

    points: NDArray[np.float64]
    z: NDArray[np.complex128]
    nearest: NDArray[np.int64]
    sigma: float
    bend: float
    scale_tolerance: float
    density: float


def make_view(
    points: NDArray[np.float64], sigma: float, bend: float, scale_tolerance: float, density: float
) -> ViewDots:
    """Return the view of dots that lie on the floor at ``points``, shape (n, 2) [m]; the rest as in `ViewDots`."""
    z = points[:, 0] + 1j * points[:, 1]
    return ViewDots(points, z, order_neighbours(points, _NEIGHBOURS), sigma, bend, scale_tolerance, density)


def mirrored(view: ViewDots) -> ViewDots:
    """Return the mirror image of a view, left and right exchanged."""
    return view._replace(points=view.points * (1.0, -1.0), z=view.z.conj())
