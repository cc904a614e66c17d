"""A robot with three cameras drives once around a furnished room."""

import math
from dataclasses import dataclass, field
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from scene_simulator.robot.robot_drive import RobotDrive, Waypoint
from scene_simulator.room.box_room import Box
from scene_simulator.room.cameras import CameraRig, render_picture
from scene_simulator.room.furniture import FurnishedRoom, Furnishing, furnish
from shirube_core.geometry import SE2, CameraMount, PinholeCamera

_PICTURE_NOISE, _POSE_NOISE = 1, 2
_PATH_STEP = 0.02
"""Time step of the path that stays free [s]."""

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
