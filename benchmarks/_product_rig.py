"""The simulator's cameras as those of stereo_landmark."""

from __future__ import annotations

from scene_simulator.stereo_rig import StereoRig as Cameras
from stereo_landmark.core.stereo import StereoRig


def product_rig(cameras: Cameras) -> StereoRig:
    """Return the same rectified cameras."""
    return StereoRig(cameras.left.intrinsics, cameras.right.intrinsics, cameras.baseline, cameras.mount)
