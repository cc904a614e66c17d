"""Lets the compiled loops be ready before the first frame comes."""

from __future__ import annotations

import numpy as np

from reward_planner.core.depth.depth_points import points_from_depth_image
from reward_planner.core.navigator import Navigator, NavigatorSettings, SensorFrame
from shirube_geometry import CameraMount, PinholeCamera, PlanarPose

_CAMERA = PinholeCamera(16, 12, 12.0, 12.0, 7.5, 5.5)


def warm_up(mount: CameraMount, settings: NavigatorSettings) -> None:
    """Map a frame and plan a route with these settings, for nothing.

    Raises:
        VoxelError: settings that leave no voxels.
    """
    navigator = Navigator(mount, settings)
    depth = np.full((_CAMERA.height, _CAMERA.width), 2.0, dtype=np.float32)
    for focal_length in (0.0, _CAMERA.fx):
        navigator.add_frame(1.0, 1.0, SensorFrame(points_from_depth_image(depth, _CAMERA), focal_length))
    navigator.add_pose(1.0, PlanarPose(0.0, 0.0, 0.0))
    navigator.pilot.set_goal(PlanarPose(-1.0, 0.3, 0.0))
    navigator.work(1.0)
    navigator.pilot.step(1.0)
