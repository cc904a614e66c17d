"""Regions of the floor that may contain the image's dots (paper 2.3.1, figs 9-13).

If image dot ``C_i`` is floor dot ``F``, all other image dots are within ``R_i`` of ``F``, where ``R_i`` is the
distance from ``C_i`` to the image dot farthest from it. So each image dot allows the union of the circles around its
candidates, and the image is where these unions overlap. As in the paper, the circles are replaced by squares, and
the overlap of a minimum number of unions is required, not of all of them.

The paper does not specify how the overlap is computed and how touching regions are separated. Here the overlap is
counted at the nodes of a grid. Every node where enough squares overlap is a region, with the candidates whose squares
cover it. At the right place each right square contains all of the image's dots, so the nodes can be as far apart as
the image is wide.

The overlap is a weak filter on a floor as dense as the paper's: with 1 px of noise a dot needs so many
candidates that more than half of the image's dots allow any given node by chance.
"""

import numpy as np
from numpy.typing import NDArray

from floor_localizer.core.arrays import Floats, Ints


def farthest_distances(image_points: Floats) -> Floats:
    """Return each image dot's distance to the image dot farthest from it, ``R_i`` of fig. 9, shape (n,) [m]."""
    return np.linalg.norm(image_points[:, None] - image_points[None, :], axis=2).max(axis=1)


def nodes_in_squares(centres: Floats, radii: Floats, pitch: float) -> tuple[NDArray[np.intp], Ints]:
    """Return which squares, with half sides ``radii`` [m], cover which nodes of the grid: indices of both,
    shape (e,) each.
    """
    low = np.ceil((centres - radii[:, None]) / pitch).astype(np.int64)
    high = np.floor((centres + radii[:, None]) / pitch).astype(np.int64)
    squares, nodes = [], []
    origin = low.min(axis=0)
    columns = int(high[:, 0].max() - origin[0]) + 1
    for step_x, step_y in np.ndindex(*np.maximum((high - low).max(axis=0), 0) + 1):
        column, row = (low + np.array([step_x, step_y])).T
        covering = np.flatnonzero((column <= high[:, 0]) & (row <= high[:, 1]))
        squares.append(covering)
        nodes.append((row[covering] - origin[1]) * columns + column[covering] - origin[0])
    return np.concatenate(squares), np.concatenate(nodes)


def candidate_regions(
    image_dots: NDArray[np.intp], candidate_points: Floats, radii: Floats, pitch: float, overlap_min: int
) -> list[NDArray[np.intp]]:
    """Return the regions where the squares of enough different image dots overlap (figs 12 and 13): indices of pairs.

    ``image_dots``, ``candidate_points`` [m] and ``radii``, ``R_i`` [m], are those of each pair (image dot, candidate);
    the overlap is counted at nodes ``pitch`` apart [m].
    """
    squares, nodes = nodes_in_squares(candidate_points, radii, pitch)
    order = np.lexsort((squares, nodes))
    next_node = np.flatnonzero(np.diff(nodes[order])) + 1
    regions = np.split(squares[order], next_node)
    return [pairs for pairs in regions if len(np.unique(image_dots[pairs])) >= overlap_min]
