"""The demo: the paper's floor, a small robot, an ordinary day's dirt, one drive out and back."""

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property

import numpy as np

from scene_simulator.errors import check_seed
from scene_simulator.floor.camera import Disturbance, FloorCamera, FloorPhoto
from scene_simulator.floor.disturbances import (
    FloorArea,
    ShadowEdge,
    SpecularReflection,
    Tape,
    WetSpot,
    crumbs,
    dust,
    hairs,
    scratches,
)
from scene_simulator.floor.dot_floor import DARK_ON_LIGHT, DotFloor, generate_dot_floor
from scene_simulator.robot.leg_drive import Suspension
from scene_simulator.robot.robot_drive import RobotDrive, Waypoint
from shirube_core.geometry import SE2, CameraMount, PinholeCamera

DEMO_FLOOR_SEED = 1812  # seed of the demo floor, whose dot map is installed with the localizer
DEMO_CAMERA = PinholeCamera(235, 235, 335.0, 335.4, 117.6, 116.3, (-0.26, 0.08, 0.0007, -0.0004, 0.0))
"""The paper's camera with a lens that bends; what it sees is 92 mm wide."""

ROUTE = (
    Waypoint(0.45, 0.55, 0.25),
    Waypoint(0.46, 1.70, 0.50),
    Waypoint(0.36, 3.10, 0.25),
    Waypoint(0.62, 4.40, 0.40),
    Waypoint(0.44, 5.80, 0.30),
    Waypoint(0.50, 7.20, 0.30),
    Waypoint(0.46, 8.30, 0.25),
    Waypoint(0.58, 8.60, 0.25),
    Waypoint(0.88, 8.72, 0.25),
    Waypoint(1.18, 8.60, 0.25),
    Waypoint(1.30, 8.30, 0.32),
    Waypoint(1.34, 7.00, 0.30, pause=3.0),
    Waypoint(1.10, 5.60, 0.40),
    Waypoint(1.36, 4.30, 0.30),
    Waypoint(1.24, 2.90, 0.50),
    Waypoint(1.34, 1.70, 0.30),
    Waypoint(1.30, 0.60, 0.0),
)
"""Out on the left half of the floor, a turn about, a stop, and back on the right half."""

EXPOSURE = 0.0015  # exposure time [s]: motion blur of two pixels at 0.5 m/s
_INSTANTS = 5
_WEAR = 0.03


@dataclass(frozen=True)
class DemoScene:
    """The scene of the recorded bag; the seed is that of dirt, wear, noise and suspension, not of the demo floor."""

    seed: int = 7

    def __post_init__(self) -> None:
        """Refuse a negative seed with a SceneError."""
        check_seed(self.seed)

    @cached_property
    def floor(self) -> DotFloor:
        """The floor as surveyed."""
        return generate_dot_floor(DARK_ON_LIGHT, DEMO_FLOOR_SEED)

    @cached_property
    def worn_floor(self) -> DotFloor:
        """The floor as it is driven on: 3 % of its chips have gone since."""
        return self.floor.remove_chips(_WEAR, self.seed)

    @cached_property
    def drive(self) -> RobotDrive:
        """The drive."""
        return RobotDrive(ROUTE)

    @cached_property
    def camera(self) -> FloorCamera:
        """The camera as it is calibrated."""
        return FloorCamera(DEMO_CAMERA)

    @property
    def mount(self) -> CameraMount:
        """Where the camera is bolted to the robot: the extrinsics as they are known."""
        return CameraMount()

    @cached_property
    def suspension(self) -> Suspension:
        """Changes the camera's height by up to 2 % and tilts it by up to 1 degree; nobody measures it."""
        return Suspension(seed=self.seed)

    @cached_property
    def disturbances(self) -> Sequence[Disturbance]:
        """Everyday dirt, with a dirtier section on the way out and a very dirty one with a mat on the way back."""
        everywhere = FloorArea((0.0, 0.0), self.floor.design.size)
        return (
            Tape((0.0, 2.10), (1.8, 2.35), 0.02),
            WetSpot((0.53, 5.20), 0.04, seed=1),
            WetSpot((1.38, 1.30), 0.03, seed=2),
            scratches(everywhere, 80.0, self.seed + 1),
            dust(everywhere, 2500.0, self.seed + 2),
            crumbs(everywhere, 300.0, self.seed + 3),
            hairs(everywhere, 80.0, self.seed + 4),
            crumbs(FloorArea((0.0, 3.2), (0.9, 4.2)), 1800.0, self.seed + 5),
            crumbs(FloorArea((0.9, 3.1), (1.8, 4.0)), 40_000.0, self.seed + 6),
            Tape((1.0, 3.5), (1.7, 3.6), 0.35, (0.14, 0.13, 0.12)),
            ShadowEdge((0.9, 6.6), 1.2),
            SpecularReflection((-0.55, 0.42), 0.035, 0.9),
            SpecularReflection((0.60, -0.50), 0.03, 0.7),
        )

    def pose_at(self, time: float) -> SE2:
        """Return ``T_map_base`` at a time [s]: the truth."""
        return self.drive.pose_at(time)

    def photograph(self, time: float, rng: np.random.Generator) -> FloorPhoto:
        """Return the picture whose exposure has its middle at a time [s]."""
        poses = self.drive.poses_during(time, EXPOSURE, _INSTANTS)
        mount = self.suspension.mount_at(time, self.mount)
        return self.camera.photograph(self.worn_floor, poses, mount, self.disturbances, rng)
