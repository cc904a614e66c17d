"""Three cameras in an L, and grey images of a room of boxes with view-independent surface texture."""

from dataclasses import dataclass

import numpy as np
from numba import njit
from numpy.typing import NDArray

from scene_simulator.imaging.exposure import camera_pose
from scene_simulator.room.box_room import BoxRoom, points_from_depth
from shirube_core.geometry import SE2, CameraMount, PinholeCamera

_GRAIN_SIZES = (0.02, 0.06, 0.2)  # sizes of the pattern [m]
_STRENGTHS = (40.0, 45.0, 40.0)
_CONTRAST_SCALE = 0.8  # size of the areas of low and high contrast [m]
_GREY = 128.0


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


def render_picture(
    room: BoxRoom, camera: PinholeCamera, T_map_camera: NDArray[np.float64], noise: float, rng: np.random.Generator
) -> NDArray[np.uint8]:
    """Return the picture from T_map_camera, shape (4, 4), with normal noise [grey levels], shape (height, width)."""
    depth = room.depth_image(camera, T_map_camera)
    points = points_from_depth(depth, camera) @ T_map_camera[:3, :3].T + T_map_camera[:3, 3]
    grey = _pattern(points).reshape(depth.shape) + rng.normal(0.0, noise, depth.shape)
    return np.clip(np.round(grey), 0, 255).astype(np.uint8)


@njit(cache=True)
def _pattern(points: NDArray[np.float64]) -> NDArray[np.float64]:
    """Return the brightness of points, shape (n,)."""
    grey = np.empty(len(points))
    for i, point in enumerate(points):
        contrast = _lattice_noise(point, _CONTRAST_SCALE)
        value = 0.0
        for grain, strength in zip(_GRAIN_SIZES, _STRENGTHS):  # noqa: B905 numba knows no strict
            value += strength * (2.0 * _lattice_noise(point, grain) - 1.0)
        grey[i] = _GREY + (0.25 + contrast) * value
    return grey


@njit(cache=True)
def _lattice_noise(point: NDArray[np.float64], size: float) -> float:
    """Return a smooth random number from 0 to 1: random ones at the corners of a lattice, between them linear."""
    x, y, z = point[0] / size + 0.37, point[1] / size + 0.61, point[2] / size + 0.19
    i, j, k = int(np.floor(x)), int(np.floor(y)), int(np.floor(z))
    u, v, w = x - i, y - j, z - k
    total = 0.0
    for a in range(2):
        for b in range(2):
            for c in range(2):
                fraction = (u if a else 1.0 - u) * (v if b else 1.0 - v) * (w if c else 1.0 - w)
                total += fraction * _corner(i + a, j + b, k + c)
    return total


@njit(cache=True)
def _corner(i: int, j: int, k: int) -> float:
    """Return the random number of a corner of the lattice, from 0 to 1 (a hash with large odd factors)."""
    h = (i * 73856093) ^ (j * 19349663) ^ (k * 83492791)
    h = ((h ^ (h >> 13)) * 1274126177) & 0xFFFFFFFF
    return ((h ^ (h >> 16)) & 0xFFFF) / 65535.0
