"""A furnished room, a depth camera in it, and the drive on which voxels are measured."""

import math

import numpy as np
from numpy.typing import NDArray

from reward_planner.core.voxels.rolling_voxel_grid import SensorView
from scene_simulator.room.box_room import BoxRoom, add_disparity_noise, forward_camera, points_from_depth
from shirube_core.geometry import SE2, PinholeCamera

CAMERA = PinholeCamera(640, 480, 525.0, 525.0, 319.5, 239.5)
CAMERA_HEIGHT = 0.5
POINTS = 272_000  # points a frame, of 307 200 pixels: a stereo camera leaves some out
FOCAL_BASELINE = 52.5
DISPARITY_SIGMA = 0.15
PHANTOM_DEPTHS = (0.4, 6.0)

ROOM = BoxRoom(
    (-4.03, -3.52, 0.0, 4.02, 3.53, 2.6),
    (
        (1.02, -0.53, 0.0, 1.47, 0.12, 0.62),  # box
        (2.03, 1.13, 0.0, 2.61, 2.02, 1.83),  # cupboard
        (-1.03, -2.73, 0.71, 0.22, -1.93, 0.77),  # table top
        *((x, y, 0.0, x + 0.05, y + 0.05, 0.71) for x in (-1.02, 0.16) for y in (-2.72, -1.99)),  # its legs
        (-3.02, 1.52, 0.82, -1.53, 2.03, 1.62),  # hangs from the wall
        (2.83, -2.47, 0.0, 3.42, -1.22, 1.03),  # shelf
        (-2.47, -0.83, 0.0, -2.12, -0.38, 0.41),  # stool
    ),
)
NEAR_WALL = BoxRoom((-4.0, -3.5, 0.0, -0.46, 3.5, 2.6))
"""A wall 0.85 m ahead fills the view: every point is within the heights and the range."""


def add_spurious_depths(
    depth: NDArray[np.float32], fraction: float, patch: int, depths: tuple[float, float], rng: np.random.Generator
) -> NDArray[np.float32]:
    """Return the image with square patches of spurious depth at uniformly random positions and depths.

    Args:
        depth: shape (height, width) [m].
        fraction: fraction of the pixels in spurious patches; less where patches overlap.
        patch: side of a patch [px]; 1 gives single points.
        depths: smallest and largest spurious depth [m].
        rng: random number generator.
    """
    height, width = depth.shape
    image = depth.copy()
    count = round(fraction * depth.size / patch**2)
    rows, columns = rng.integers(0, height - patch + 1, count), rng.integers(0, width - patch + 1, count)
    for row, column, z in zip(rows, columns, rng.uniform(*depths, count), strict=True):
        image[row : row + patch, column : column + patch] = z
    return image


def view_at(pose: SE2) -> SensorView:
    """Return the view of a camera over a pose, level and ahead."""
    return SensorView(forward_camera(pose.x, pose.y, CAMERA_HEIGHT, pose.yaw), CAMERA.fx)


def points_at(
    room: BoxRoom,
    pose: SE2,
    rng: np.random.Generator,
    phantoms: tuple[float, int] = (0.0, 1),
    phantom_rng: np.random.Generator | None = None,
) -> NDArray[np.float32]:
    """Return what the camera measures, shape (POINTS, 3), in the optical frame [m].

    Args:
        room: boxes of the room.
        pose: pose of the robot.
        rng: source of the noise and of the pixels without depth.
        phantoms: their share and the side of a patch [px].
        phantom_rng: source of the phantoms.
    """
    depth = room.depth_image(CAMERA, view_at(pose).T_map_sensor)
    depth = add_disparity_noise(depth, FOCAL_BASELINE, DISPARITY_SIGMA, rng)
    if phantom_rng is not None:
        depth = add_spurious_depths(depth, *phantoms, PHANTOM_DEPTHS, phantom_rng)
    kept = np.sort(rng.permutation(depth.size)[:POINTS])
    return points_from_depth(depth, CAMERA)[kept]


def stationary_poses(frames: int) -> list[SE2]:
    """Return the poses of a stationary robot."""
    return [SE2(-1.31, 0.07, 0.03)] * frames


def moving_poses(frames: int) -> list[SE2]:
    """Return the poses of a robot that drives a slow arc through the room and comes back along it."""
    steps = [*range(frames // 2), *reversed(range(frames // 2))]
    return [SE2(-2.2 + 0.04 * k, 0.5 * math.sin(0.05 * k), 0.6 * math.sin(0.1 * k)) for k in steps]
