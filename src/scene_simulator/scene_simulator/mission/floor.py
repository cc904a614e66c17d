"""The mission's floor: sparse round chips as of a printed mat, dirt, a carpet that hides them."""

from dataclasses import dataclass, field
from functools import cached_property

import numpy as np

from scene_simulator.floor.camera import Disturbance, FloorCamera, FloorPhoto
from scene_simulator.floor.disturbances import FloorArea, SpecularReflection, Tape, crumbs, dust, hairs
from scene_simulator.floor.dot_floor import DotFloor, FloorDesign, generate_dot_floor
from scene_simulator.mission.layout import CARPET, ROOM
from shirube_core.geometry import SE2, CameraMount, PinholeCamera

DESIGN = FloorDesign(size=(ROOM[3], ROOM[4]), count=57_600, diameters=(0.004, 0.006), min_distance=0.0035)
"""1200 chips a square meter; about fifty are in view."""

BELLY_CAMERA = FloorCamera(PinholeCamera(235, 235, 150.0, 150.0, 117.0, 117.0))
"""It sees 0.2 x 0.2 m from 0.13 m."""

BELLY_MOUNT = CameraMount()
EXPOSURE = 0.0015
"""[s]"""

_FLOOR_SEED = 2612
_WEAR = 0.03
_CARPET_COLOUR = (0.22, 0.2, 0.3)


def surveyed_floor() -> DotFloor:
    """Return the floor as surveyed; it is always the same."""
    return generate_dot_floor(DESIGN, _FLOOR_SEED)


@dataclass(frozen=True)
class MissionFloor:
    """The floor as it is driven on.

    Attributes:
        seed: seed of wear and dirt.
        surveyed: floor as surveyed, before wear.
    """

    seed: int
    surveyed: DotFloor = field(default_factory=surveyed_floor)

    @cached_property
    def worn(self) -> DotFloor:
        """The floor without the chips that have gone."""
        return self.surveyed.remove_chips(_WEAR, self.seed)

    @cached_property
    def disturbances(self) -> tuple[Disturbance, ...]:
        """Disturbances of the floor, the carpet last."""
        everywhere = FloorArea((0.0, 0.0), DESIGN.size)
        (left, low), (right, high) = CARPET.low, CARPET.high
        middle = 0.5 * (low + high)
        return (
            dust(everywhere, 400.0, self.seed + 2),
            crumbs(everywhere, 100.0, self.seed + 3),
            hairs(everywhere, 20.0, self.seed + 4),
            Tape((left, middle), (right, middle), high - low, _CARPET_COLOUR),
            SpecularReflection((-0.55, 0.42), 0.035, 0.9),
        )

    def photograph(self, poses: list[SE2], mount: CameraMount, rng: np.random.Generator) -> FloorPhoto:
        """Return the picture of an exposure: ``T_map_base`` at even instants, mount in the upright frame."""
        return BELLY_CAMERA.photograph(self.worn, poses, mount, self.disturbances, rng)
