"""Primitives of a stereo pair with its cameras."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from shirube_geometry import LevelCamera, level_camera
from stereo_landmark.core.place.stereo_rig import StereoRig
from stereo_landmark.core.procedure.detected_scene import DetectedKind, DetectedScene
from stereo_landmark.core.procedure.primitive import Kind
from stereo_landmark.core.procedure.stereo_matching import alike_pairs, match_pairs

DEPTHS = (0.3, 30.0)
"""Minimum and maximum depth of a landmark [m]."""

WEIGHTS = {Kind.ELLIPSE: 1.0, Kind.QUADRILATERAL: 1.0, Kind.PARALLEL_LINES: 0.5, Kind.CORNER: 0.2}
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
    def camera(self) -> LevelCamera:
        """Left camera in the gravity-aligned base frame."""
        return level_camera(self.rig.mount, *self.tilt)

    def both(self, kind: Kind) -> tuple[DetectedKind, DetectedKind]:
        """Return the primitives of a kind in the left and in the right image."""
        return self.left.kinds[kind], self.right.kinds[kind]

    def partners_of(self, kind: Kind) -> NDArray[np.int64]:
        """Return the index of the right primitive matched to each left one, shape (n,); -1 without a match."""
        if kind not in self._partners:
            # Primitives of all kinds support each other, but only those of this kind are matched now.
            numbers = match_pairs(
                [self.left.kinds[each].centres for each in self._pairs],
                list(self._pairs.values()),
                [self._disparities(each, pairs) for each, pairs in self._pairs.items()],
                [WEIGHTS[each] for each in self._pairs],
                list(self._pairs).index(kind),
            )
            self._partners[kind] = np.full(len(self.left.kinds[kind].primitives), -1)
            self._partners[kind][numbers[:, 0]] = numbers[:, 1]
        return self._partners[kind]

    @cached_property
    def _partners(self) -> dict[Kind, NDArray[np.int64]]:
        """Cached matches by kind."""
        return {}

    @cached_property
    def _pairs(self) -> dict[Kind, NDArray[np.int64]]:
        """Candidate pairs by kind, each of shape (m, 2)."""
        return {kind: self._alike(kind) for kind in self.left.kinds}

    def _alike(self, kind: Kind) -> NDArray[np.int64]:
        here, there = self.both(kind)
        scale = self.rig.left.fx * self.rig.baseline
        return alike_pairs(
            here.centres - [self.rig.left.cx, 0.0],
            here.descriptors,
            there.centres - [self.rig.right.cx, 0.0],
            there.descriptors,
            (scale / DEPTHS[1], scale / DEPTHS[0]),
        )

    def _disparities(self, kind: Kind, numbers: NDArray[np.int64]) -> NDArray[np.float64]:
        here, there = self.both(kind)
        left, right = here.centres[numbers[:, 0], 0], there.centres[numbers[:, 1], 0]
        return np.asarray((left - self.rig.left.cx) - (right - self.rig.right.cx))
