"""Three calibrated cameras in an L; the images tell on which side the third one is."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from reward_planner.core.depth.depth_error import DepthError
from reward_planner.core.depth.depth_settings import DepthSettings
from reward_planner.core.depth.stereo_pair import pair_from_projections
from reward_planner.core.depth.trinocular_depth import DepthImage, TrinocularDepth

_CONTRADICTION_MAX = 0.5  # pairs that belong together contradict each other in a few pixels of a hundred


class TrinocularRig:
    """Depth of three cameras.

    Calibrations differ in the sign of the vertical baseline: P[1, 3] is -fy B with B along y, which points down, but
    B is written as a positive number for a camera above as well. Only one of both makes the pairs see the same.

    Where too few pixels are seen by both pairs to tell whether these belong together (a covered camera, noise, swapped
    images), only what both see alike is believed.

    Attributes:
        is_mirrored: whether the images show the top camera on the other side than its calibration says.
    """

    def __init__(self, projections: NDArray[np.float64], settings: DepthSettings) -> None:
        """Prepare the matchers.

        Args:
            projections: shape (3, 3, 4), the matrices P of the left, right and top camera.
            settings: of the matching.

        Raises:
            DepthError: cameras that are not rectified to each other, or settings that OpenCV has no matcher for.
        """
        left, right, top = projections
        beside, above = pair_from_projections(left, right), pair_from_projections(left, top)
        self.is_mirrored = False
        self._is_confirmed: bool | None = None  # by the latest frame that told
        self._as_told = TrinocularDepth(beside, above, settings)
        self._mirrored = TrinocularDepth(beside, above.mirrored(), settings)

    def compute(
        self, left: NDArray[np.uint8], right: NDArray[np.uint8], top: NDArray[np.uint8]
    ) -> DepthImage:
        """Return the depth; arguments as of `TrinocularDepth.compute`.

        Raises:
            DepthError: images that do not fit, pairs that contradict each other on either side, or that did in the
                latest frame that told.
        """
        seen = self._pairs(self.is_mirrored).compute(left, right, top)
        if _belong_together(seen):
            self._is_confirmed = True
            return seen
        if seen.contradiction is not None or self._is_confirmed is None:
            other = self._pairs(not self.is_mirrored).compute(left, right, top)
            if _belong_together(other):
                self.is_mirrored, self._is_confirmed = not self.is_mirrored, True
                return other
        if seen.contradiction is not None:
            self._is_confirmed = False
        if self._is_confirmed is False:
            raise DepthError(
                'the depths of left-right and left-top contradict each other; check that the topics are those of these '
                'cameras, and calibrate them together'
            )
        return seen.agreed()

    def _pairs(self, is_mirrored: bool) -> TrinocularDepth:
        return self._mirrored if is_mirrored else self._as_told


def _belong_together(seen: DepthImage) -> bool:
    return seen.contradiction is not None and seen.contradiction <= _CONTRADICTION_MAX
