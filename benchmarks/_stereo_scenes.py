"""The cameras of the rendered stereo benchmarks, what they see, and where the robot comes back to."""

import numpy as np
from _stereo_peers import product_rig
from numpy.typing import NDArray

from scene_simulator.corridor.stereo_rig import StereoRig
from shirube_core.geometry import SE2
from stereo_landmark.core.landmark_localizer import LandmarkFix, NoLandmarkFix

Pair = tuple[NDArray[np.uint8], NDArray[np.uint8]]  # left and right image, each of shape (h, w)
RIG = StereoRig()
CAMERAS = product_rig(RIG)


def random_offset(distance: float, turn: float, rng: np.random.Generator) -> SE2:
    """Return an offset, uniform up to a distance along each axis [m] and a turn [rad]."""
    limits = np.array([distance, distance, turn])
    return SE2(*rng.uniform(-limits, limits).tolist())


def displacement_of(answer: LandmarkFix | NoLandmarkFix) -> SE2 | None:
    """Return the displacement that a localizer found."""
    return answer.displacement.T_place_base if isinstance(answer, LandmarkFix) else None


def left_pixels(points: NDArray[np.float64], T_map_base: SE2) -> NDArray[np.float64]:
    """Return where the left camera sees points, shape (n, 3) in the map frame: shape (n, 2) [px]."""
    pose = RIG.camera_poses(T_map_base)[0]
    return RIG.left.intrinsics.pixels_from_points(pose.camera_points(points))


def seen_by_both(points: NDArray[np.float64], T_map_base: SE2, border: float) -> NDArray[np.bool_]:
    """Return which points, shape (n, 3) in the map frame, both cameras see farther than a border [px] inside."""
    seen = np.ones(len(points), dtype=np.bool_)
    for camera, pose in zip((RIG.left, RIG.right), RIG.camera_poses(T_map_base), strict=True):
        size = np.array([camera.intrinsics.width, camera.intrinsics.height])
        pixels = camera.intrinsics.pixels_from_points(pose.camera_points(points))
        seen &= ((pixels >= border) & (pixels <= size - 1.0 - border)).all(axis=1)
    return seen
