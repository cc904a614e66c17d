"""A robot with three cameras drives once around a furnished room."""

import math
from dataclasses import dataclass, field
from functools import cached_property

import numpy as np
from numba import njit
from numpy.typing import NDArray

from scene_simulator.imaging.exposure import camera_pose
from scene_simulator.robot.robot_drive import RobotDrive, Waypoint
from scene_simulator.room.box_room import Box, BoxRoom, points_from_depth
from scene_simulator.room.furniture import FurnishedRoom, Furnishing, furnish
from shirube_core.geometry import SE2, CameraMount, PinholeCamera

_GRAIN_SIZES = (0.02, 0.06, 0.2)  # sizes of the pattern [m]
_STRENGTHS = (40.0, 45.0, 40.0)
_CONTRAST_SCALE = 0.8  # size of the areas of low and high contrast [m]
_GREY = 128.0


@dataclass(frozen=True)
class CameraRig:
    """An L of rectified cameras: intrinsics of all, mount of the left one, distance of the others from it [m]."""

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


_PICTURE_NOISE, _POSE_NOISE = 1, 2
_PATH_STEP = 0.02  # time step of the path that stays free [s]
_SPEED = 0.55
_CORNERS = ((-2.6, -1.1), (-1.5, -1.7), (0.3, -1.3), (2.1, -1.6), (2.7, -0.3), (2.2, 1.4), (0.5, 1.7), (-1.6, 1.5))
RIG = CameraRig(
    PinholeCamera(320, 240, 262.5, 262.5, 159.5, 119.5),
    CameraMount((0.1, 0.05, 0.4), (-math.pi / 2.0, 0.0, -math.pi / 2.0)),
    0.1,
)
"""Level, looking ahead."""


def room_loop() -> RobotDrive:
    """Return a drive along the walls, almost back to its start."""
    corners = (*_CORNERS, (-2.7, 0.3), (-2.5, -0.7))
    return RobotDrive([Waypoint(x, y, _SPEED) for x, y in corners])


@dataclass(frozen=True)
class RoomDrive:
    """What a drive through a room is made of; equal fields give equal pictures.

    Attributes:
        seed: seed of furniture and noise.
        size: the room's own corners [m].
        furnishing: number of furniture items.
        rig: the robot's cameras.
        clearance: minimum distance between the robot's centre and the furniture [m].
        picture_noise: standard deviation of a pixel [grey levels].
        pose_noise: standard deviation of the localizer's x and y [m] and of its yaw [rad].
    """

    seed: int = 1
    size: Box = (-4.03, -3.02, 0.0, 4.02, 3.03, 2.5)
    furnishing: Furnishing = field(default_factory=Furnishing)
    rig: CameraRig = RIG
    clearance: float = 0.5
    picture_noise: float = 2.0
    pose_noise: tuple[float, float] = (0.003, 0.002)

    @cached_property
    def drive(self) -> RobotDrive:
        """The robot's drive."""
        return room_loop()

    @cached_property
    def room(self) -> FurnishedRoom:
        """The room, or a SceneError for too much furniture or a negative seed."""
        times = np.arange(0.0, self.drive.duration, _PATH_STEP).tolist()
        path = [(pose.x, pose.y) for pose in map(self.drive.pose_at, times)]
        return furnish(self.size, self.furnishing, self.seed, path, self.clearance)

    def pictures(self, index: int, time: float) -> dict[str, NDArray[np.uint8]]:
        """Return what the cameras see at a time [s], shape (height, width), by name; the index seeds the noise."""
        rng = np.random.default_rng((self.seed, _PICTURE_NOISE, index))
        boxes, noise = self.room.boxes, self.picture_noise
        views = self.rig.views(self.drive.pose_at(time))
        return {name: render_picture(boxes, self.rig.camera, view, noise, rng) for name, view in views.items()}

    def localizer_pose(self, index: int, time: float) -> SE2:
        """Return ``T_map_base`` as a localizer measures it, with noise; arguments as for `pictures`."""
        rng = np.random.default_rng((self.seed, _POSE_NOISE, index))
        x, y, yaw = rng.normal(0.0, (self.pose_noise[0], *self.pose_noise)).tolist()
        pose = self.drive.pose_at(time)
        return SE2(pose.x + x, pose.y + y, pose.yaw + yaw)
