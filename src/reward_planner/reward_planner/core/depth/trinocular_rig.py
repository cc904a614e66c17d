"""Three calibrated cameras in an L; the side of the top camera is found from the images."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from reward_planner.core.depth.depth_error import DepthError
from reward_planner.core.depth.depth_settings import DepthSettings
from reward_planner.core.depth.stereo_pair import pair_from_projections
from reward_planner.core.depth.trinocular_depth import DepthImage, TrinocularDepth

_INCONSISTENT_FRACTION_MAX = 0.5  # consistent pairs differ in a few percent of the pixels


class TrinocularRig:
    """Depth of three cameras.

    Calibrations differ in the sign of the vertical baseline: P[1, 3] is -fy B with B along y, which points down, but
    some tools write a positive B for a camera above as well. Only the right sign makes the pairs consistent.

    If both pairs see too few common pixels for this check (a covered camera, noise, swapped images), only depths that
    both confirm are returned.

    Attributes:
        is_mirrored: whether the top camera is on the opposite side of what its calibration says.
    """

    def __init__(self, projections: NDArray[np.float64], settings: DepthSettings) -> None:
        """Prepare the matchers.

        Args:
            projections: projection matrices P of the left, right and top camera, shape (3, 3, 4).
            settings: settings of stereo matching.

        Raises:
            DepthError: cameras that are not rectified to each other, or settings that OpenCV does not support.
        """
        left, right, top = projections
        horizontal, vertical = pair_from_projections(left, right), pair_from_projections(left, top)
        self.is_mirrored = False
        self._is_confirmed: bool | None = None  # by the latest frame with enough common pixels
        self._as_calibrated = TrinocularDepth(horizontal, vertical, settings)
        self._mirrored = TrinocularDepth(horizontal, vertical.mirror(), settings)

    def compute(
        self, left: NDArray[np.uint8], right: NDArray[np.uint8], top: NDArray[np.uint8]
    ) -> DepthImage:
        """Return the depth; arguments as for `TrinocularDepth.compute`.

        Raises:
            DepthError: images of a wrong type or shape, or pairs that are inconsistent with either sign, now or in the
                latest frame with enough common pixels.
        """
        depth = self._pairs(self.is_mirrored).compute(left, right, top)
        if _is_consistent(depth):
            self._is_confirmed = True
            return depth
        if depth.inconsistent_fraction is not None or self._is_confirmed is None:
            mirrored_depth = self._pairs(not self.is_mirrored).compute(left, right, top)
            if _is_consistent(mirrored_depth):
                self.is_mirrored, self._is_confirmed = not self.is_mirrored, True
                return mirrored_depth
        if depth.inconsistent_fraction is not None:
            self._is_confirmed = False
        if self._is_confirmed is False:
            raise DepthError(
                'the depths of left-right and left-top are inconsistent; check that the topics are those of these '
                'cameras, and calibrate them together'
            )
        return depth.only_consistent()

    def _pairs(self, is_mirrored: bool) -> TrinocularDepth:
        return self._mirrored if is_mirrored else self._as_calibrated


def _is_consistent(depth: DepthImage) -> bool:
    return (
        depth.inconsistent_fraction is not None and depth.inconsistent_fraction <= _INCONSISTENT_FRACTION_MAX
    )
