"""A robot's drive in a corridor: what its stereo rig, its wheels and its inertial unit record, and the truth."""

from __future__ import annotations

import math
from collections.abc import Iterator
from dataclasses import dataclass, field, replace

import numpy as np
from numpy.typing import NDArray

from scene_simulator.corridor_scene import CorridorScene
from scene_simulator.errors import SceneError, check_seed
from scene_simulator.lamp_drive import GOOD_WHEEL_ERRORS
from scene_simulator.leg_drive import LegDrive
from scene_simulator.stereo_rig import StereoRig, render_pair
from scene_simulator.suspension import Suspension
from scene_simulator.tilt_sensor import TiltErrors, TiltReading, simulate_tilt
from scene_simulator.wheel_odometry import WheelErrors, WheelReading, simulate_wheel_readings
from shirube_core.geometry import SE2

STIFF_SUSPENSION = Suspension(heave=0.0005, tilt=math.radians(0.2))
"""Suspension that hardly moves: a mast with cameras on a slow robot."""

_IMAGE_NOISE, _WHEELS, _TILT = range(3)


@dataclass(frozen=True)
class StereoFrame:
    """A pair of pictures and the truth about it.

    Attributes:
        stamp: when both were taken [s].
        left: shape (height, width).
        right: shape (height, width).
        pose: ``T_map_base`` at the stamp.
    """

    stamp: float
    left: NDArray[np.uint8]
    right: NDArray[np.uint8]
    pose: SE2


@dataclass(frozen=True)
class StereoDrive:
    """Everything that is recorded on a drive; the same seed gives the same recording.

    Attributes:
        scene: the corridor.
        route: the true drive.
        rig: the cameras, while the body is at rest.
        rate: frame rate [Hz].
        suspension: heave and tilt of the body.
        wheels: errors of the odometry.
        tilt: errors of the inertial unit.
        seed: seed of noise and errors; the suspension has a separate seed.
    """

    scene: CorridorScene
    route: LegDrive
    rig: StereoRig = field(default_factory=StereoRig)
    rate: float = 3.0
    suspension: Suspension = STIFF_SUSPENSION
    wheels: WheelErrors = GOOD_WHEEL_ERRORS
    tilt: TiltErrors = field(default_factory=TiltErrors)
    seed: int = 0

    def __post_init__(self) -> None:
        """Refuse a negative seed or a rate that is not positive with a SceneError."""
        check_seed(self.seed)
        if not 0.0 < self.rate < math.inf:
            raise SceneError(f'{self.rate} pictures a second cannot be taken: give a positive number')

    def pose_at(self, time: float) -> SE2:
        """Return ``T_map_base`` at a time [s], its place and heading on the floor: the truth."""
        return self.route.pose_at(time)

    def tilt_at(self, time: float) -> tuple[float, float]:
        """Return the true fixed-axis roll and pitch of ``base_link`` at a time [s] in [rad]."""
        _, roll, pitch = self.suspension.motion_at(time).tolist()
        return roll, pitch

    def frame_count(self, seconds: float) -> int:
        """Return how many frames ``frames`` yields.

        Raises:
            SceneError: the time is not positive.
        """
        if not 0.0 < seconds < math.inf:
            raise SceneError(f'the recording is {seconds} s long: give a positive number of seconds')
        return math.ceil(seconds * self.rate - 1e-9)

    def frames(self, seconds: float) -> Iterator[StereoFrame]:
        """Yield the frames of the first seconds one by one.

        Raises:
            SceneError: the time is not positive.
        """
        for index in range(self.frame_count(seconds)):
            stamp, noise = index / self.rate, self._rng(_IMAGE_NOISE, index)
            rig = replace(self.rig, mount=self.suspension.mount_at(stamp, self.rig.mount))
            pose = self.pose_at(stamp)
            yield StereoFrame(stamp, *render_pair(self.scene, rig, pose, noise), pose)

    def odometry(self, seconds: float, period: float = 0.02) -> list[WheelReading]:
        """Return the wheel odometry of the first seconds, a reading each period [s]."""
        return simulate_wheel_readings(self.pose_at, seconds, period, self.wheels, self._rng(_WHEELS))

    def tilt_readings(self, seconds: float, period: float = 0.02) -> list[TiltReading]:
        """Return the inertial unit's tilt in the first seconds, a reading each period [s]."""
        times = np.arange(0.0, seconds, period).tolist()
        return simulate_tilt(self.tilt_at, times, self.tilt, self._rng(_TILT))

    def _rng(self, *purpose: int) -> np.random.Generator:
        return np.random.default_rng((self.seed, *purpose))
