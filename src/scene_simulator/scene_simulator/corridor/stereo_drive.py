"""A robot's drive in a corridor: what its stereo rig, its wheels and its inertial unit record, and the truth.

``RUNS`` are recorded drives in one corridor: one teach run and repeat runs with changed views.
"""

import math
from collections.abc import Iterator
from dataclasses import dataclass, field, replace

import numpy as np
from numpy.typing import NDArray

from scene_simulator.ceiling.lamp_drive import GOOD_WHEEL_ERRORS
from scene_simulator.corridor.generator import CorridorDesign, corridor
from scene_simulator.corridor.scene import CorridorScene, Person
from scene_simulator.corridor.shapes import CorridorLight, facing_wall
from scene_simulator.corridor.stereo_rig import StereoRig, render_pair
from scene_simulator.errors import SceneError, check_seed
from scene_simulator.robot.leg_drive import LegDrive, Suspension, TiltErrors
from scene_simulator.robot.robot_drive import SensorDrive, WheelErrors
from shirube_core.geometry import SE2

STIFF_SUSPENSION = Suspension(heave=0.0005, tilt=math.radians(0.2))
"""Suspension that hardly moves: a mast with cameras on a slow robot."""

_IMAGE_NOISE = 0
TAUGHT_POSE = SE2(-3.0, 0.0, 0.0)  # taught pose ``T_map_place``

_RUN_UP, _SPEED, _REST = 1.0, 0.5, 0.5  # distance to the goal [m], speed [m/s], pause before the start [s]
SECONDS = 5.0  # duration of a drive; the robot is stationary at its goal for the last second [s]


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
class StereoDrive(SensorDrive):
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

    WHEEL_STREAM, TILT_STREAM = 1, 2
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

    def frame_count(self, seconds: float) -> int:
        """Return how many frames ``frames`` yields, or raise SceneError if the time is not positive."""
        if not 0.0 < seconds < math.inf:
            raise SceneError(f'the recording is {seconds} s long: give a positive number of seconds')
        return math.ceil(seconds * self.rate - 1e-9)

    def frames(self, seconds: float) -> Iterator[StereoFrame]:
        """Yield the frames of the first seconds one by one, or raise SceneError if the time is not positive."""
        for index in range(self.frame_count(seconds)):
            stamp, noise = index / self.rate, self.rng(_IMAGE_NOISE, index)
            rig = replace(self.rig, mount=self.suspension.mount_at(stamp, self.rig.mount))
            pose = self.pose_at(stamp)
            yield StereoFrame(stamp, *render_pair(self.scene, rig, pose, noise), pose)


@dataclass(frozen=True)
class CorridorRun:
    """A drive straight up to a goal.

    Attributes:
        ahead: forward offset of the goal from the taught pose [m].
        left: offset of the goal to the left of the taught pose [m].
        yaw: yaw of the goal relative to the taught pose, counter-clockwise [rad].
        change: change of the scene: ``light``, ``hidden``, ``moved``, or nothing.
    """

    ahead: float
    left: float
    yaw: float
    change: str = ''

    @property
    def goal(self) -> SE2:
        """``T_map_base`` at the end."""
        return TAUGHT_POSE @ SE2(self.ahead, self.left, self.yaw)

    @property
    def route(self) -> LegDrive:
        """The drive to the goal."""
        start = self.goal @ SE2(-_RUN_UP, 0.0, 0.0)
        return LegDrive([(start.x, start.y), (self.goal.x, self.goal.y)], [_SPEED], 0.1, _REST)

    def apply_change(self, scene: CorridorScene) -> CorridorScene:
        """Return the corridor with the change of this drive."""
        if self.change == 'light':
            return replace(scene, light=CorridorLight(0.57, (0.015, 0.16, -0.05)))
        if self.change == 'hidden':
            passer_by = Person('passer_by', facing_wall(-0.7), (0.55, 0.0))
            return scene.cover_landmark('meter_1').with_objects([passer_by])
        return scene.move_object('round_sign', -0.2, 0.12) if self.change == 'moved' else scene


RUNS = {
    'teach': CorridorRun(0.0, 0.0, 0.0),
    'left': CorridorRun(-0.2, 0.5, math.radians(-15.0)),
    'right': CorridorRun(0.2, -0.5, math.radians(15.0)),
    'light': CorridorRun(-0.15, 0.2, math.radians(-4.0), 'light'),
    'hidden': CorridorRun(0.1, -0.2, math.radians(5.0), 'hidden'),
    'moved': CorridorRun(-0.1, -0.1, math.radians(-3.0), 'moved'),
}


def make_corridor_drive(run: str, design: CorridorDesign | None = None, rig: StereoRig | None = None) -> StereoDrive:
    """Return one of ``RUNS``, or raise SceneError; the meter readings differ between runs."""
    if run not in RUNS:
        raise SceneError(f'there is no run {run!r}: choose one of {", ".join(RUNS)}')
    chosen, number = design or CorridorDesign(), list(RUNS).index(run)
    scene = RUNS[run].apply_change(corridor(replace(chosen, needles=number)))
    return StereoDrive(scene, RUNS[run].route, rig or StereoRig(), seed=number)
