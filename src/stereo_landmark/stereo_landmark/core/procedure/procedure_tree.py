"""The paper's search of a target in one image: a procedure tree in windows (paper 3.4, figs 7 and 8).

A path of the tree begins with a primitive, the surest first, and searches the others in their order, in windows around
the positions that the primitives found before predict.
"""

import math
from collections.abc import Sequence
from typing import NamedTuple

from stereo_landmark.core.arrays import Floats
from stereo_landmark.core.primitives.primitive import Primitive, primitive_size
from stereo_landmark.core.procedure.pose_hypotheses import SAME_PLACE
from stereo_landmark.core.procedure.window_detector import Detection, WindowDetector
from stereo_landmark.core.settings import SearchSettings

GROWTH_FIRST, GROWTH = 0.2, 0.1
"""Growth of a window per pixel of distance, while one primitive gives the scale, and when several do."""
BRANCHES_MAX = 4
"""Maximum number of combinations of one first candidate that are followed."""
SIZE_TOLERANCE = 0.2
"""Difference of the logarithm of a size from that of the other primitives at which the misfit is 1."""
COMBINATIONS_MAX = 12
"""Maximum number of combinations of an image."""


class Combination(NamedTuple):
    """Primitives of one image that may be those of the target (fig. 8).

    Attributes:
        found: detected primitives by their index in the order of detection.
        misfit: mean difference in shape, position and size, 0 for the taught ones, 1 at the tolerances.
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
        combinations.sort(key=lambda each: (-len(each.found), each.misfit))
        best: dict[tuple[object, ...], Combination] = {}
        for each in combinations:
            if len(each.found) >= needed:
                places = (
                    (k, round(found.centre.real / SAME_PLACE), round(found.centre.imag / SAME_PLACE))
                    for k, found in sorted(each.found.items())
                )
                best.setdefault(tuple(places), each)
        return list(best.values())[:COMBINATIONS_MAX]

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
        mean, taught_mean, scale, is_known = self._similarity(found)
        growth = GROWTH if is_known else GROWTH_FIRST
        for index in range(len(self._sizes)):
            if index in found:
                continue
            # Window of the primitive [px].
            step = scale * (self._centres[index] - taught_mean)
            radius = self._settings.window + growth * abs(step)
            branches = []
            for candidate in self._detector.find(index, mean + step, radius):
                grown = {**found, index: candidate}
                branches.append(Combination(grown, self._misfit(grown)))
            # Without a candidate, the branch with the next weight is followed; later windows are smaller.
            if branches:
                return branches
        return []

    def _similarity(self, found: dict[int, Detection]) -> tuple[complex, complex, complex, bool]:
        """Return the mean centres, found and taught, scale and rotation, and whether several centres give these."""
        count, first = len(found), next(iter(found))
        mean = sum(each.centre for each in found.values()) / count
        taught_mean = sum(self._centres[k] for k in found) / count
        spread = sum(abs(self._centres[k] - taught_mean) ** 2 for k in found)
        if spread <= self._settings.window**2:
            return mean, taught_mean, complex(found[first].size / self._sizes[first]), False
        turned = ((each.centre - mean) * (self._centres[k] - taught_mean).conjugate() for k, each in found.items())
        return mean, taught_mean, sum(turned) / spread, True

    def _misfit(self, found: dict[int, Detection]) -> float:
        """Return the mean difference of the primitives in shape, position and size."""
        mean, taught_mean, scale, _ = self._similarity(found)
        total = 0.0
        for k, each in found.items():
            apart = abs(each.centre - mean - scale * (self._centres[k] - taught_mean))
            growth = abs(math.log(each.size / (self._sizes[k] * abs(scale)))) if self._sizes[k] > 1.0 else 0.0
            total += each.difference + apart / self._settings.window + growth / SIZE_TOLERANCE
        return total / (3.0 * len(found))
