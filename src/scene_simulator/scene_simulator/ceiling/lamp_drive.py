"""A robot's drive under ceiling lamps: what its camera, its wheels and its inertial unit record, and the truth."""

import math
from collections.abc import Iterator
from dataclasses import dataclass, field
from typing import Protocol

import numpy as np

from scene_simulator.ceiling.camera import UPWARD_MOUNT, CeilingCamera, CeilingPhoto
from scene_simulator.ceiling.room import CeilingRoom
from scene_simulator.errors import check_seed
from scene_simulator.imaging.exposure import CameraClock, CameraPose, camera_pose
from scene_simulator.robot.body import Suspension, TiltErrors, TiltReading, simulate_tilt
from scene_simulator.robot.wheel_odometry import WheelErrors, WheelReading, simulate_wheel_readings
from shirube_core.geometry import SE2, CameraMount

GOOD_WHEEL_ERRORS = WheelErrors(left_scale=1.0195, right_scale=1.0205, slip=0.0002)
"""Good wheels: 2 % too much distance and rotation, and 0.2 degrees a metre to the left."""

FIRM_SUSPENSION = Suspension(heave=0.001, tilt=math.radians(1.0))
"""A body that heaves by a millimetre and tilts by up to a degree."""

_IMAGE_NOISE, _CLOCK, _WHEELS, _TILT = range(4)


class Route(Protocol):
    """Where the robot truly is."""

    def pose_at(self, time: float) -> SE2:
        """Return ``T_map_base`` at a time [s]."""


@dataclass(frozen=True)
class LampFrame:
    """A frame of the camera and the truth about it.

    Attributes:
        stamp: stamp of the image [s].
        photo: image, true times and projections of the lamps.
        pose: ``T_map_base`` at the true start of the frame, of which the stamp is the reading.
    """

    stamp: float
    photo: CeilingPhoto
    pose: SE2


@dataclass(frozen=True)
class LampDrive:
    """Everything that is recorded on a drive; the same seed gives the same recording.

    Attributes:
        room: ceiling and lights.
        route: the true drive, a ``LegDrive`` or a ``RobotDrive``.
        camera: looks up.
        mount: pose of the camera in ``base_link`` while the body is at rest.
        suspension: heave and tilt of the body.
        clock: rhythm of the camera.
        wheels: errors of the odometry.
        tilt: errors of the inertial unit.
        seed: seed of noise and errors; the suspension has a separate seed.
    """

    room: CeilingRoom
    route: Route
    camera: CeilingCamera = field(default_factory=CeilingCamera)
    mount: CameraMount = UPWARD_MOUNT
    suspension: Suspension = FIRM_SUSPENSION
    clock: CameraClock = field(default_factory=CameraClock)
    wheels: WheelErrors = GOOD_WHEEL_ERRORS
    tilt: TiltErrors = field(default_factory=TiltErrors)
    seed: int = 0

    def __post_init__(self) -> None:
        """Refuse a negative seed with a SceneError."""
        check_seed(self.seed)

    def pose_at(self, time: float) -> SE2:
        """Return ``T_map_base`` at a time [s], its place and heading on the floor: the truth."""
        return self.route.pose_at(time)

    def tilt_at(self, time: float) -> tuple[float, float]:
        """Return the true fixed-axis roll and pitch of ``base_link`` at a time [s] in [rad]."""
        _, roll, pitch = self.suspension.motion_at(time).tolist()
        return roll, pitch

    def camera_pose_at(self, time: float) -> CameraPose:
        """Return ``T_map_camera`` at a time [s]."""
        return camera_pose(self.pose_at(time), self.suspension.mount_at(time, self.mount))

    def frame_count(self, seconds: float) -> int:
        """Return how many frames ``frames`` yields."""
        return len(self.clock.frames(seconds, self._rng(_CLOCK))[0])

    def frames(self, seconds: float) -> Iterator[LampFrame]:
        """Yield the frames of the first seconds one by one, or raise SceneError if the time is not positive."""
        starts, stamps = self.clock.frames(seconds, self._rng(_CLOCK))
        for index, (start, stamp) in enumerate(zip(starts.tolist(), stamps.tolist(), strict=True)):
            noise = self._rng(_IMAGE_NOISE, index)
            photo = self.camera.photograph(self.room, self.camera_pose_at, start, noise)
            yield LampFrame(stamp, photo, self.pose_at(start))

    def odometry(self, seconds: float, period: float = 0.02) -> list[WheelReading]:
        """Return the wheel odometry of the first seconds, a reading each period [s]."""
        return simulate_wheel_readings(self.pose_at, seconds, period, self.wheels, self._rng(_WHEELS))

    def tilt_readings(self, seconds: float, period: float = 0.01) -> list[TiltReading]:
        """Return the inertial unit's tilt in the first seconds, a reading each period [s]."""
        times = np.arange(0.0, seconds, period).tolist()
        return simulate_tilt(self.tilt_at, times, self.tilt, self._rng(_TILT))

    def _rng(self, *purpose: int) -> np.random.Generator:
        return np.random.default_rng((self.seed, *purpose))
