"""Geometric congruence: candidates whose distances agree with those of their image dots (paper 2.3.2, figs 14-20).

The printed figures contradict each other: in fig. 18 (whose column sums 6, 2, 3, 5, 6, 5, 5, 4 the text
repeats) ``F_2b`` agrees with all of ``F_1a``, ``F_3``, ``F_4`` and ``F_5``, so the text's rule keeps these
five with sums of 4, but fig. 19 shows ``F_2b`` removed and sums of 3. The text's rule is implemented here.
"""

import math

import numpy as np
from numba import njit
from numpy.typing import NDArray

from floor_localizer.core.arrays import Booleans, Floats
from shirube_core.geometry import SE2


@njit(cache=True)
def mutual_distances(points: Floats, image_dots: NDArray[np.intp]) -> Floats:
    """Return the matrix of mutual distances, ``C_d`` of fig. 16 or ``F_d`` of fig. 17, shape (m, m) [m].

    ``points`` are the image dot or the candidate of each pair (image dot, candidate), shape (m, 2) [m]. The distance is
    NaN (NA in the paper) between pairs of the same image dot.
    """
    distances = np.full((len(points), len(points)), np.nan)
    for i in range(len(points)):
        for j in range(i):
            if image_dots[i] != image_dots[j]:
                x, y = points[i, 0] - points[j, 0], points[i, 1] - points[j, 1]
                distances[i, j] = distances[j, i] = math.sqrt(x * x + y * y)
    return distances


@njit(cache=True)
def agreement_matrix(C_d: Floats, F_d: Floats, tolerance: float) -> Booleans:
    """Return the 0/1 matrix of fig. 18: true where both distances agree within the tolerance [m], false for NA."""
    return np.abs(C_d - F_d) <= tolerance


@njit(cache=True)
def prune_to_congruent(agreement: Booleans) -> NDArray[np.intp]:
    """Remove the pair with the lowest column sum until every sum is one less than the remaining number (fig. 19).

    The paper does not specify which of several lowest columns is removed; here it is the first. The agreement matrix is
    symmetric and false on the diagonal; returned are the ascending indices of the pairs that all agree with each other.
    """
    sums = agreement.sum(axis=0)
    remaining = np.arange(len(agreement))
    while len(remaining) > 0:
        lowest = np.argmin(sums[remaining])
        if sums[remaining[lowest]] == len(remaining) - 1:
            break
        sums -= agreement[remaining[lowest]]
        remaining = np.delete(remaining, lowest)
    return remaining


def fit_pose(image_points: Floats, map_points: Floats) -> SE2:
    """Return the least-squares pose ``T_map_view`` of paired dots, shape (n, 2) [m], two or more, without
    reflection.
    """
    image_centre, map_centre = image_points.mean(axis=0), map_points.mean(axis=0)
    a, b = (image_points - image_centre).T, (map_points - map_centre).T
    yaw = math.atan2(float(a[0] @ b[1] - a[1] @ b[0]), float(a[0] @ b[0] + a[1] @ b[1]))
    turn = SE2(0.0, 0.0, yaw)
    shift = map_centre - turn.transform(image_centre)
    return SE2(float(shift[0]), float(shift[1]), yaw)
