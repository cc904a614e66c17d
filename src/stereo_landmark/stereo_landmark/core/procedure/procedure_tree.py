"""The paper's search of a target in one image: a procedure tree in windows (paper 3.4, figs 7 and 8).

A path of the tree begins with a primitive, the surest first, and searches the others in their order, in windows around
the positions that the primitives found before predict.
"""

import math
from collections.abc import Sequence
from typing import NamedTuple

import numpy as np

from stereo_landmark.core.arrays import Floats, GreyImage
from stereo_landmark.core.edges.edges import SIDE_MIN
from stereo_landmark.core.primitives.primitive import (
    ImageProcessing,
    Primitive,
    bounding_box,
    primitive_kind,
    primitive_size,
    shape_differences,
    shape_sizes,
    shape_vectors,
    shift,
)
from stereo_landmark.core.procedure.pose_hypotheses import SAME_PLACE
from stereo_landmark.core.procedure.stereo_view import DetectedPrimitives, detect_scene
from stereo_landmark.core.settings import SearchSettings

GROWTH_MAX = 1.3
"""Growth of a primitive since teaching up to which the window shows it wholly."""
MARGIN = 8.0
"""Margin of the window for the edge filter and noise removal [px]."""


class SearchRegion(NamedTuple):
    """The region in which the centre of a primitive can be.

    Attributes:
        taught: taught shape.
        low: upper left corner, shape (2,) [px].
        high: lower right corner, shape (2,) [px].
    """

    taught: Primitive
    low: Floats
    high: Floats


class Detection(NamedTuple):
    """A detected primitive that is similar to a taught one.

    Attributes:
        detected: primitives of its kind.
        number: its index among them.
        offset: offset of the window in which they are detected, shape (2,) [px].
        centre: centre in the image, in the complex plane [px].
        size: size [px].
        difference: difference from the taught shape, 0 for none, 1 at the tolerance.
    """

    detected: DetectedPrimitives
    number: int
    offset: Floats
    centre: complex
    size: float
    difference: float

    @property
    def primitive(self) -> Primitive:
        """The primitive in the coordinates of the image."""
        return shift(self.detected.primitives[self.number], self.offset)


class WindowDetector:
    """Detects the primitives of a target in its window of an image.

    Args:
        image: grey image, shape (h, w).
        processing: image processing that was taught for the target.
        regions: regions of its primitives.
    """

    def __init__(self, image: GreyImage, processing: ImageProcessing, regions: Sequence[SearchRegion]) -> None:
        reaches = [GROWTH_MAX * (bounding_box(each.taught) - each.taught.centre) for each in regions]
        low = np.min([each.low + reach[0] for each, reach in zip(regions, reaches, strict=True)], axis=0)
        high = np.max([each.high + reach[1] for each, reach in zip(regions, reaches, strict=True)], axis=0)
        corners = np.clip(np.rint([low - MARGIN, high + MARGIN]), 0, image.shape[::-1])
        (left, top), (right, bottom) = corners.astype(int).tolist()
        if min(right - left, bottom - top) < SIDE_MIN:
            self._similar = [(np.empty((0, 2)), list[Detection]()) for _ in regions]
            return
        window, kinds = image[top:bottom, left:right], {primitive_kind(each.taught) for each in regions}
        scene = detect_scene(np.ascontiguousarray(window), processing, kinds)
        self._similar = [
            _find_similar(each, scene.kinds[primitive_kind(each.taught)], processing, corners[0]) for each in regions
        ]

    def find(self, index: int, centre: complex = 0.0j, radius: float = np.inf) -> list[Detection]:
        """Return the detections of a primitive within a radius of a predicted centre in the complex plane [px]."""
        centres, detections = self._similar[index]
        is_near = np.hypot(centres[:, 0] - centre.real, centres[:, 1] - centre.imag) <= radius
        return [detections[i] for i in np.flatnonzero(is_near).tolist()]


def _find_similar(
    region: SearchRegion, detected: DetectedPrimitives, processing: ImageProcessing, offset: Floats
) -> tuple[Floats, list[Detection]]:
    """Return the primitives in a region that are similar to the taught one, and their centres, shape (n, 2) [px]."""
    centres = detected.centres + offset
    vectors = detected.shape_vectors, shape_vectors(detected.kind, [region.taught])
    (differences,) = shape_differences(detected.kind, *vectors, processing.tolerances)
    is_inside = ((centres >= region.low) & (centres <= region.high)).all(axis=1)
    chosen = np.flatnonzero(is_inside & (differences <= 1.0))
    sizes = shape_sizes(detected.kind, detected.shape_vectors)
    detections = [
        Detection(detected, i, offset, complex(*centres[i]), float(sizes[i]), float(differences[i]))
        for i in chosen.tolist()
    ]
    return centres[chosen], detections


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
