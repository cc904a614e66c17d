"""The paper's search of a target in one image: a procedure tree in windows (paper 3.4, figs 7 and 8).

A path of the tree begins with a primitive, the surest first, and searches the others in their order, in windows around
the positions that the primitives found before predict.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import NamedTuple

from stereo_landmark.core.arrays import Floats
from stereo_landmark.core.primitives.primitive import Primitive, primitive_size
from stereo_landmark.core.procedure.window_detector import Detection, WindowDetector
from stereo_landmark.core.settings import SearchSettings

GROWTH_FIRST, GROWTH = 0.2, 0.1
"""Growth of a window per pixel of distance, while one primitive gives the scale, and when several do."""
BRANCHES_MAX = 4
"""Maximum number of combinations of one first candidate that are followed."""
COMBINATIONS_MAX = 12
"""Maximum number of combinations of an image."""


class Combination(NamedTuple):
    """Primitives of one image that may be those of the target (fig. 8).

    Attributes:
        found: detected primitives by their index in the order of detection.
        misfit: mean difference in shape and position, 0 for the taught ones, 1 at the tolerances.
    """

    found: dict[int, Detection]
    misfit: float


class ProcedureTree:
    """The procedure tree of a target for one image (fig. 7). Its weights are the order of the primitives.

    Args:
        detector: detector of the image.
        shapes: taught shapes of its primitives, the surest first.
        centres: taught centres in this camera's image, shape (k, 2) [px].
        settings: search settings.
    """

    def __init__(
        self, detector: WindowDetector, shapes: Sequence[Primitive], centres: Floats, settings: SearchSettings
    ) -> None:
        self._detector = detector
        self._sizes = [primitive_size(shape) for shape in shapes]
        self._centres = (centres @ [1.0, 1.0j]).tolist()
        self._settings = settings

    def search(self, first: int) -> list[Combination]:
        """Return the combinations of the paths that begin with a primitive, the best ones first.

        Args:
            first: index of the primitive; that of the branch a, b, c... of the root.
        """
        needed = max(1, math.ceil(self._settings.found_fraction_min * len(self._sizes) - 1e-9))
        combinations: list[Combination] = []
        # Each candidate P1i, then P2j(P1i), then P3k(P2j(P1i)).
        for candidate in self._detector.find(first):
            combinations += self._follow(Combination({first: candidate}, candidate.difference))
        # The combinations with the most primitives, and of these the nearest to the taught ones.
        enough = [each for each in combinations if len(each.found) >= needed]
        enough.sort(key=lambda each: (-len(each.found), each.misfit))
        return enough[:COMBINATIONS_MAX]

    def _follow(self, start: Combination) -> list[Combination]:
        """Return complete combinations that begin with a candidate."""
        complete: list[Combination] = []
        growing = [start]
        while growing:
            grown: list[Combination] = []
            for combination in growing:
                branches = self._branch(combination)
                grown += branches
                if not branches:
                    complete.append(combination)
            growing = sorted(grown, key=lambda each: each.misfit)[:BRANCHES_MAX]
        return complete

    def _branch(self, combination: Combination) -> list[Combination]:
        """Return a combination with each candidate of the surest missing primitive that has one."""
        found = combination.found
        for index in range(len(self._sizes)):
            if index in found:
                continue
            centre, radius = self._window(found, index)
            branches = []
            for candidate in self._detector.find(index, centre, radius):
                misfit = 0.5 * (candidate.difference + abs(candidate.centre - centre) / radius)
                mean = combination.misfit + (misfit - combination.misfit) / (len(found) + 1)
                branches.append(Combination({**found, index: candidate}, mean))
            # Without a candidate, the branch with the next weight is followed; later windows are smaller.
            if branches:
                return branches
        return []

    def _window(self, found: dict[int, Detection], index: int) -> tuple[complex, float]:
        """Return centre, in the complex plane, and radius of the window of a primitive [px]."""
        count, first = len(found), next(iter(found))
        mean = sum(each.centre for each in found.values()) / count
        taught_mean = sum(self._centres[k] for k in found) / count
        # Position, rotation and scale by the centres found; with one of them, the scale by its size.
        spread = sum(abs(self._centres[k] - taught_mean) ** 2 for k in found)
        if spread > self._settings.window**2:
            turned = (
                (each.centre - mean) * (self._centres[k] - taught_mean).conjugate()
                for k, each in found.items()
            )
            scale, growth = sum(turned) / spread, GROWTH
        else:
            scale, growth = complex(found[first].size / self._sizes[first]), GROWTH_FIRST
        step = scale * (self._centres[index] - taught_mean)
        return mean + step, self._settings.window + growth * abs(step)
