"""The dots of all submaps, in an array store; bounding boxes and the last used matchers are in memory."""

from collections import OrderedDict

import numpy as np

from floor_localizer.core.arrays import Complexes, Floats, Ints
from floor_localizer.core.survey.array_store import ArrayStore
from floor_localizer.core.survey.dot_matching import DotMatcher
from shirube_core.geometry import SE2

_CACHE_SIZE = 64


class SubmapMatchers:
    """Dot matchers of all submaps, each in its own frame, with an LRU cache."""

    def __init__(self, store: ArrayStore) -> None:
        """Begin without a submap."""
        self._store = store
        self._cache: OrderedDict[int, DotMatcher] = OrderedDict()
        # Lower and upper corner of each submap, with spare capacity.
        self._corners = np.empty((_CACHE_SIZE, 2, 2))
        self._count = 0

    def append(self, dots: Floats) -> None:
        """Add the dots of the next submap, shape (n, 2) [m], n >= 1."""
        if self._count == len(self._corners):
            self._corners = np.concatenate([self._corners, np.empty_like(self._corners)])
        self._store.put('submap', self._count, dots)
        self._corners[self._count] = dots.min(axis=0), dots.max(axis=0)
        self._count += 1

    def dots(self, index: int) -> Floats:
        """Return the dots of a submap, shape (n, 2) [m]."""
        (dots,) = self._store.get('submap', index)
        return dots

    def __getitem__(self, index: int) -> DotMatcher:
        """Return the matcher of a submap."""
        if index not in self._cache:
            self._cache[index] = DotMatcher(self.dots(index))
            if len(self._cache) > _CACHE_SIZE:
                self._cache.popitem(last=False)
        self._cache.move_to_end(index)
        return self._cache[index]

    def may_overlap(self, index: int, other: int, pose: SE2, radius: float) -> bool:
        """Return whether the bounding boxes of two submaps may overlap, given the pose of the first in the
        frame of the other and the uncertainty of its position [m].
        """
        transformed, (lower, upper) = pose.transform(self[index].points), self._corners[other]
        return bool(
            (transformed.min(axis=0) - radius < upper).all() and (transformed.max(axis=0) + radius > lower).all()
        )

    def overlap_candidates(self, index: int, rotations: Complexes, translations: Complexes, radius: float) -> Ints:
        """Return a superset of the submaps for which `may_overlap` is true, by bounding circles.

        ``rotations``, shape (n,), are complex and of magnitude 1, ``translations`` are complex, shape (n,) [m].
        """
        lower, upper = (self._corners[: self._count] @ (1.0, 1j)).T
        centres, sizes = rotations * (0.5 * (lower + upper)) + translations, 0.5 * np.abs(upper - lower)
        # The bounding box of a rotated box is larger than its bounding circle.
        radii = np.sqrt(2.0) * (sizes[index] + radius) + sizes
        return np.flatnonzero(np.abs(centres - centres[index]) <= 1.0001 * radii)
