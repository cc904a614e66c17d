"""The dots of a map to extend, in an array store from which only a region is read."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from floor_localizer.core.survey.array_store import ArrayStore


@dataclass(frozen=True)
class ExistingDots:
    """Dots of the existing map, sorted by x.

    Attributes:
        store: array store of the dots.
        count: number of dots.
    """

    store: ArrayStore
    count: int

    def query(
        self, places: NDArray[np.float64], max_distance: float
    ) -> tuple[NDArray[np.int64], NDArray[np.float64]]:
        """Return all dots within a distance of the bounding box of some points.

        Args:
            places: points, shape (m, 2) [m].
            max_distance: distance [m].

        Returns:
            the indices, ascending, shape (k,), and the dots, shape (k, 2) [m].
        """
        if len(places) == 0 or self.count == 0:
            return np.empty(0, dtype=np.int64), np.empty((0, 2))
        lower, upper = places.min(axis=0) - max_distance, places.max(axis=0) + max_distance
        sorted_dots, indices = self.store.memory_map('existing'), self.store.memory_map('existing_indices')
        begin = np.searchsorted(sorted_dots[:, 0], lower[0])
        end = np.searchsorted(sorted_dots[:, 0], upper[0], side='right')
        strip = np.array(sorted_dots[begin:end])
        rows = np.flatnonzero((strip[:, 1] >= lower[1]) & (strip[:, 1] <= upper[1]))
        rows = rows[np.argsort(indices[begin + rows])]
        return np.array(indices[begin + rows]), strip[rows]


def store_existing_dots(points: NDArray[np.float64], store: ArrayStore) -> ExistingDots:
    """Store the dots of the existing map, shape (n, 2) [m]."""
    order = np.argsort(points[:, 0], kind='stable')
    store.put('existing', 0, points[order])
    store.put('existing_indices', 0, order)
    return ExistingDots(store, len(points))
