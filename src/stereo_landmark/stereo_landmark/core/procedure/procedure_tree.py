"""The paper's search of a target in one image: a procedure tree in windows (paper 3.4, figs 7 and 8).

A path of the tree begins with a primitive, the surest first, and searches the others in their order, in windows around
the positions that the primitives found before predict. Paths without enough primitives are followed by the next one.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from stereo_landmark.core.arrays import Floats
from stereo_landmark.core.primitives.primitive import Primitive, primitive_size
from stereo_landmark.core.procedure.window_detector import WindowDetector
from stereo_landmark.core.settings import SearchSettings

GROWTH_FIRST, GROWTH = 0.2, 0.1
"""Growth of a window per pixel of distance, while one primitive gives the scale, and when several do."""
BRANCHES_MAX = 4
"""Maximum number of combinations of one first candidate that are followed."""
COMBINATIONS_MAX = 12
"""Maximum number of combinations of an image."""


@dataclass(frozen=True)
class Combination:
    """Primitives of one image that may be those of the target (fig. 8).

    Attributes:
        found: detected primitives by their index in the order of detection.
        misfit: mean difference in shape and position, 0 for the taught ones, 1 at the tolerances.
    """

    found: dict[int, Primitive]
    misfit: float


class ProcedureTree:
    """The procedure tree of a target for one image (fig. 7). Its weights are the order of the primitives.

    Args:
        shapes: taught shapes of its primitives, the surest first.
        centres: taught centres in this camera's image, shape (k, 2) [px].
        regions: upper left and lower right corner of the region where each can be, shape (k, 2, 2) [px].
        settings: search settings.
    """

    def __init__(
        self, shapes: Sequence[Primitive], centres: Floats, regions: Floats, settings: SearchSettings
    ) -> None:
        self._shapes, self._centres, self._regions, self._settings = shapes, centres, regions, settings

    def search(self, detector: WindowDetector) -> list[Combination]:
        """Return combinations of the first path that finds enough primitives, the best ones first.

        Args:
            detector: detector of the image.
        """
        needed = max(1, math.ceil(self._settings.found_fraction_min * len(self._shapes) - 1e-9))
        # The branches of the root in the order of their weights, a > b > c.
        for first, (low, high) in enumerate(self._regions):
            combinations: list[Combination] = []
            # Each candidate P1i, then P2j(P1i), then P3k(P2j(P1i)).
            for candidate, difference in detector.find(self._shapes[first], low, high):
                combinations += self._follow(Combination({first: candidate}, difference), detector)
            # The combinations with the most primitives, and of these the nearest to the taught ones.
            enough = [each for each in combinations if len(each.found) >= needed]
            if enough:
                enough.sort(key=lambda each: (-len(each.found), each.misfit))
                return enough[:COMBINATIONS_MAX]
        return []

    def _follow(self, start: Combination, detector: WindowDetector) -> list[Combination]:
        """Return complete combinations that begin with a candidate."""
        complete: list[Combination] = []
        growing = [start]
        while growing:
            grown: list[Combination] = []
            for combination in growing:
                branches = self._branch(combination, detector)
                grown += branches
                if not branches:
                    complete.append(combination)
            growing = sorted(grown, key=lambda each: each.misfit)[:BRANCHES_MAX]
        return complete

    def _branch(self, combination: Combination, detector: WindowDetector) -> list[Combination]:
        """Return a combination with each candidate of the surest missing primitive that has one."""
        found = combination.found
        for index, shape in enumerate(self._shapes):
            if index in found:
                continue
            centre, radius = self._window(found, index)
            branches = []
            low, high = self._regions[index]
            low, high = np.maximum(low, centre - radius), np.minimum(high, centre + radius)
            for candidate, difference in detector.find(shape, low, high):
                distance = float(np.hypot(*(candidate.centre - centre)))
                misfit = 0.5 * (difference + distance / radius)
                mean = combination.misfit + (misfit - combination.misfit) / (len(found) + 1)
                branches.append(Combination({**found, index: candidate}, mean))
            # Without a candidate, the branch with the next weight is followed; later windows are smaller.
            if branches:
                return branches
        return []

    def _window(self, found: dict[int, Primitive], index: int) -> tuple[Floats, float]:
        """Return centre, shape (2,), and radius of the window of a primitive [px]."""
        indices = list(found)
        here = np.array([each.centre for each in found.values()]) @ [1.0, 1.0j]
        there = self._centres[indices] @ [1.0, 1.0j]
        # Position, rotation and scale by the centres found; with one of them, the scale by its size.
        offsets = there - there.mean()
        spread = float(np.sum(np.abs(offsets) ** 2))
        scale = complex(primitive_size(found[indices[0]]) / primitive_size(self._shapes[indices[0]]))
        growth = GROWTH_FIRST
        if spread > self._settings.window**2:
            scale, growth = complex(np.sum((here - here.mean()) * offsets.conj())) / spread, GROWTH
        step = scale * (complex(*self._centres[index]) - there.mean())
        centre = complex(here.mean()) + step
        return np.array([centre.real, centre.imag]), self._settings.window + growth * abs(step)
