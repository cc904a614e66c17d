"""Both images of a moment and the cameras that took them."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

from shirube_geometry import LevelCamera, level_camera
from stereo_landmark.core.place.stereo_rig import StereoRig
from stereo_landmark.core.procedure.detected_scene import DetectedKind, DetectedScene
from stereo_landmark.core.procedure.primitive import Kind


@dataclass(frozen=True)
class StereoView:
    """What both cameras show.

    Attributes:
        left: the left image.
        right: the right image.
        rig: the cameras.
        tilt: roll and pitch of the base [rad].
    """

    left: DetectedScene
    right: DetectedScene
    rig: StereoRig
    tilt: tuple[float, float] = (0.0, 0.0)

    @cached_property
    def camera(self) -> LevelCamera:
        """The left one on the robot that leans."""
        return level_camera(self.rig.mount, *self.tilt)

    def both(self, kind: Kind) -> tuple[DetectedKind, DetectedKind]:
        """Return the primitives of a kind in the left and in the right image."""
        return self.left.kinds[kind], self.right.kinds[kind]
