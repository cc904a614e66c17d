"""The match rate: the fraction of the image's dots that match a dot of the floor (paper 2.3.3, fig. 21)."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray


@dataclass(frozen=True)
class AddressMatrix:
    """The floor divided into square blocks; a block is occupied if it contains a dot.

    Attributes:
        occupied: shape (rows, columns), row along y, column along x.
        origin: shape (2,), lower left corner of block (0, 0) in the map frame [m].
        block: side of a block [m].
    """

    occupied: NDArray[np.bool_]
    origin: NDArray[np.float64]
    block: float


def build_address_matrix(map_points: NDArray[np.float64], block: float) -> AddressMatrix:
    """Return the address matrix of a floor.

    Args:
        map_points: shape (N, 2), the floor's dots in the map frame [m], at least one.
        block: side of a block [m]; the paper takes 2.8 mm for dots of 2 to 3 mm (3.3.5).
    """
    origin = map_points.min(axis=0)
    columns, rows = ((map_points - origin) / block).astype(np.intp).T
    occupied = np.zeros((rows.max() + 1, columns.max() + 1), dtype=np.bool_)
    occupied[rows, columns] = True
    return AddressMatrix(occupied, origin, block)


def match_rate(address_matrix: AddressMatrix, points: NDArray[np.float64]) -> float:
    """Return the fraction of dots that are in an occupied block.

    Args:
        address_matrix: the floor's blocks.
        points: shape (n, 2), all dots of the image, transformed to the map frame [m].

    Returns:
        the match rate in [0, 1]; dots off the floor do not match, and the rate of no dots is 0.
    """
    if len(points) == 0:
        return 0.0
    columns, rows = np.floor((points - address_matrix.origin) / address_matrix.block).astype(np.intp).T
    height, width = address_matrix.occupied.shape
    inside = (rows >= 0) & (rows < height) & (columns >= 0) & (columns < width)
    return float(address_matrix.occupied[rows[inside], columns[inside]].sum() / len(points))
