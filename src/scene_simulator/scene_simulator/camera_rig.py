"""Three cameras in an L: the left one, one to its right, one above it; all look the same way."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from scene_simulator.camera_motion import camera_pose
from shirube_core.geometry import SE2, CameraMount, PinholeCamera


@dataclass(frozen=True)
class CameraRig:
    """An L of rectified cameras.

    Attributes:
        camera: intrinsics of all three cameras, without distortion.
        mount: pose of the left camera's optical frame in ``base_link``.
        baseline: distance from the left camera to each of the others [m].
    """

    camera: PinholeCamera
    mount: CameraMount
    baseline: float

    @property
    def camera_offsets(self) -> dict[str, tuple[float, float]]:
        """Camera positions in the left camera's optical frame, x to the right and y down [m], by name."""
        return {'left': (0.0, 0.0), 'right': (self.baseline, 0.0), 'top': (0.0, -self.baseline)}

    @property
    def projections(self) -> dict[str, NDArray[np.float64]]:
        """The matrices P of the cameras, shape (3, 4), by name."""
        matrix = self.camera.matrix
        return {
            name: np.column_stack([matrix, 0.0 - matrix @ (*offset, 0.0)])
            for name, offset in self.camera_offsets.items()
        }

    def views(self, T_map_base: SE2) -> dict[str, NDArray[np.float64]]:
        """Return ``T_map_camera`` of each camera, shape (4, 4), by name."""
        pose = camera_pose(T_map_base, self.mount)
        views = {}
        for name, (x, y) in self.camera_offsets.items():
            view = np.eye(4)
            view[:3, :3] = pose.rotation
            view[:3, 3] = pose.position + pose.rotation @ (x, y, 0.0)
            views[name] = view
        return views
