"""Primitives of a stereo pair with its cameras."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from shirube_core.geometry import GravityAlignedCamera, gravity_aligned_camera
from stereo_landmark.core.place.stereo_rig import StereoRig
from stereo_landmark.core.procedure.detected_scene import DetectedPrimitives, DetectedScene
from stereo_landmark.core.procedure.primitive import PrimitiveKind
from stereo_landmark.core.procedure.stereo_matching import candidate_pairs, match_pairs

DEPTH_RANGE = (0.3, 30.0)
"""Minimum and maximum depth of a landmark [m]."""

SUPPORT_WEIGHTS = {
    PrimitiveKind.ELLIPSE: 1.0,
    PrimitiveKind.QUADRILATERAL: 1.0,
    PrimitiveKind.PARALLEL_LINES: 0.5,
    PrimitiveKind.CORNER: 0.2,
}
"""Support weight of a primitive for its neighbours: many corners are visible in one camera only."""


@dataclass(frozen=True)
class StereoView:
    """Detected primitives of both images.

    Attributes:
        left: primitives of the left image.
        right: primitives of the right image, of the same kinds.
        rig: stereo cameras.
        tilt: roll and pitch of the base [rad].
    """

    left: DetectedScene
    right: DetectedScene
    rig: StereoRig
    tilt: tuple[float, float] = (0.0, 0.0)

    @cached_property
    def camera(self) -> GravityAlignedCamera:
        """Left camera in the gravity-aligned base frame."""
        return gravity_aligned_camera(self.rig.mount, *self.tilt)

    def detected_pair(self, kind: PrimitiveKind) -> tuple[DetectedPrimitives, DetectedPrimitives]:
        """Return the primitives of a kind in the left and in the right image."""
        return self.left.kinds[kind], self.right.kinds[kind]

    def match_indices(self, kind: PrimitiveKind) -> NDArray[np.int64]:
        """Return the index of the right primitive matched to each left one, shape (n,); -1 without a match."""
        if kind not in self._matches:
            # Primitives of all kinds support each other, but only those of this kind are matched now.
            indices = match_pairs(
                [self.left.kinds[each].centres for each in self._candidates],
                list(self._candidates.values()),
                [self._disparities(each, pairs) for each, pairs in self._candidates.items()],
                [SUPPORT_WEIGHTS[each] for each in self._candidates],
                list(self._candidates).index(kind),
            )
            self._matches[kind] = np.full(len(self.left.kinds[kind].primitives), -1)
            self._matches[kind][indices[:, 0]] = indices[:, 1]
        return self._matches[kind]

    @cached_property
    def _matches(self) -> dict[PrimitiveKind, NDArray[np.int64]]:
        """Cached matches by kind."""
        return {}

    @cached_property
    def _candidates(self) -> dict[PrimitiveKind, NDArray[np.int64]]:
        """Candidate pairs by kind, each of shape (m, 2)."""
        return {kind: self._candidate_pairs(kind) for kind in self.left.kinds}

    def _candidate_pairs(self, kind: PrimitiveKind) -> NDArray[np.int64]:
        here, there = self.detected_pair(kind)
        scale = self.rig.left.fx * self.rig.baseline
        return candidate_pairs(
            here.centres - [self.rig.left.cx, 0.0],
            here.descriptors,
            there.centres - [self.rig.right.cx, 0.0],
            there.descriptors,
            (scale / DEPTH_RANGE[1], scale / DEPTH_RANGE[0]),
        )

    def _disparities(self, kind: PrimitiveKind, indices: NDArray[np.int64]) -> NDArray[np.float64]:
        here, there = self.detected_pair(kind)
        left, right = here.centres[indices[:, 0], 0], there.centres[indices[:, 1], 0]
        return np.asarray((left - self.rig.left.cx) - (right - self.rig.right.cx))
