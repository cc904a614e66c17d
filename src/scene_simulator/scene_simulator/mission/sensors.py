"""Sensors of the mission's robot: each image depends only on the seed, its number and the true motion."""

import math
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field, replace
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from scene_simulator.ceiling.room import CeilingRoom, Person
from scene_simulator.corridor.scene import CorridorScene
from scene_simulator.corridor.stereo_drive import STIFF_SUSPENSION
from scene_simulator.corridor.stereo_rig import StereoRig
from scene_simulator.imaging.exposure import CameraPose, camera_pose
from scene_simulator.mission.landmarks import FurnishedScene, covered_walls
from scene_simulator.mission.layout import (
    BELLY_MOUNT,
    CEILING_CAMERA,
    CEILING_MOUNT,
    EXPOSURE,
    MissionFloor,
    MissionLayout,
    lamps_near,
    mission_ceiling,
    mission_layout,
    mission_obstacles,
)
from scene_simulator.mission.pedestrians import HEIGHT, RADIUS, Place, solids_at
from scene_simulator.robot.leg_drive import Suspension, TiltErrors, TiltReading
from scene_simulator.room.box_room import add_disparity_noise
from scene_simulator.room.furniture import FurnishedRoom
from shirube_core.geometry import SE2, CameraMount, PinholeCamera
from shirube_core.waveform import Waveform

PoseAt = Callable[[float], SE2]  # gives ``T_map_base`` at a time [s]
DEPTH_CAMERA = PinholeCamera(160, 120, 100.0, 100.0, 79.5, 59.5)
DEPTH_MOUNT = CameraMount((0.1, 0.0, 0.4), (-0.5 * math.pi, 0.0, -0.5 * math.pi))  # level, looking ahead
STEREO_RIG = StereoRig()
_DEPTH_BASELINE, _DEPTH_SIGMA = 0.05, 0.02  # baseline of the depth camera [m] and its disparity noise [px]
_INSTANTS = 3  # number of instants per exposure of the floor camera
_FLOOR, _CEILING, _STEREO, _DEPTH, _TILT, _BIAS = range(6)  # random number streams


@dataclass(frozen=True)
class MissionSensors:
    """The room of a seed and the robot's sensors in it.

    Attributes:
        seed: seed of room, errors and noise.
        waveforms: waveform of each lamp, by its ID.
        walls: walls with their landmarks.
        tilt: errors of the inertial unit.
    """

    seed: int
    waveforms: Mapping[int, Waveform] = field(repr=False)
    walls: CorridorScene = field(default_factory=covered_walls, repr=False)
    tilt: TiltErrors = field(default_factory=TiltErrors)

    @cached_property
    def layout(self) -> MissionLayout:
        """Start and goals."""
        return mission_layout(self.seed)

    @cached_property
    def room(self) -> FurnishedRoom:
        """The furnished room."""
        return mission_obstacles(self.seed, self.layout)

    @cached_property
    def floor(self) -> MissionFloor:
        """The floor with its dirt."""
        return MissionFloor(self.seed)

    @cached_property
    def ceiling(self) -> CeilingRoom:
        """The lamps."""
        return mission_ceiling(self.waveforms, self.seed)

    @cached_property
    def suspension(self) -> Suspension:
        """Heave and tilt of the body."""
        return replace(STIFF_SUSPENSION, seed=self.seed)

    def floor_picture(self, index: int, time: float, pose_at: PoseAt) -> NDArray[np.uint8]:
        """Return the belly camera's picture, shape (height, width), the middle of whose exposure is at a time [s].

        Args:
            index: number of the picture; decides its noise, here and in the other methods. These also take people in
                the room, by their places.
            time: [s].
            pose_at: gives the true pose during the exposure.
        """
        fractions = np.linspace(-0.5, 0.5, _INSTANTS).tolist()
        poses = [pose_at(time + fraction * EXPOSURE) for fraction in fractions]
        mount = self.suspension.mount_at(time, BELLY_MOUNT)
        return self.floor.photograph(poses, mount, self._rng(_FLOOR, index)).image

    def ceiling_picture(
        self, index: int, time: float, pose_at: PoseAt, people: Sequence[Place] = ()
    ) -> NDArray[np.uint8]:
        """Return the ceiling camera's picture, shape (height, width), whose first row begins at a time [s]."""

        def camera_pose_at(exposure_time: float) -> CameraPose:
            return camera_pose(pose_at(exposure_time), self.suspension.mount_at(exposure_time, CEILING_MOUNT))

        pose = pose_at(time)
        near = lamps_near(self.ceiling, pose.x, pose.y)
        near = replace(near, people=tuple(Person(at, at, HEIGHT, 0.0, RADIUS) for at in people))
        return CEILING_CAMERA.photograph(near, camera_pose_at, time, self._rng(_CEILING, index)).image

    def stereo_pair(
        self, index: int, time: float, pose_at: PoseAt, people: Sequence[Place] = ()
    ) -> tuple[NDArray[np.uint8], NDArray[np.uint8]]:
        """Return the pictures of the left and the right camera at a time [s], each of shape (height, width)."""
        rig = replace(STEREO_RIG, mount=self.suspension.mount_at(time, STEREO_RIG.mount))
        bodies = tuple((x - RADIUS, y - RADIUS, 0.0, x + RADIUS, y + RADIUS, HEIGHT) for x, y in people)
        rng, walls = self._rng(_STEREO, index), FurnishedScene(self.walls, self.room.boxes.boxes + bodies)
        left, right = rig.camera_poses(pose_at(time))
        return (
            rig.left.photograph(walls.order_for_camera(left.position), left, rng),
            rig.right.photograph(walls.order_for_camera(right.position), right, rng),
        )

    def depth_picture(
        self, index: int, time: float, pose_at: PoseAt, people: Sequence[Place] = ()
    ) -> NDArray[np.float32]:
        """Return the depths that the depth camera measures at a time [s], shape (height, width) [m]."""
        pose = camera_pose(pose_at(time), self.suspension.mount_at(time, DEPTH_MOUNT))
        view = np.eye(4)
        view[:3, :3], view[:3, 3] = pose.rotation, pose.position
        depth = self.room.boxes.depth_image(DEPTH_CAMERA, view, solids_at(people))
        return add_disparity_noise(depth, DEPTH_CAMERA.fx * _DEPTH_BASELINE, _DEPTH_SIGMA, self._rng(_DEPTH, index))

    def tilt_reading(self, index: int, time: float) -> TiltReading:
        """Return the reading of the inertial unit at a time [s]."""
        _, *true = self.suspension.motion_at(time).tolist()
        bias = self.tilt.bias * self._rng(_BIAS).standard_normal(2)
        roll, pitch = (true + bias + self.tilt.noise * self._rng(_TILT, index).standard_normal(2)).tolist()
        return TiltReading(time, roll, pitch)

    def _rng(self, *purpose: int) -> np.random.Generator:
        return np.random.default_rng((self.seed, *purpose))
