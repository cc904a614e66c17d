"""The mission: start, goals, obstacles, and the zones in which one localizer has no measurements.

The room's lower left corner is the origin of the map. The building is always the same; the seed decides the furniture
and the exact start and goals.
"""

import math
from collections.abc import Mapping
from dataclasses import dataclass, field
from functools import cached_property

import numpy as np
from numpy.typing import NDArray
from scipy.ndimage import distance_transform_edt, label

from scene_simulator.ceiling.camera import CeilingCamera
from scene_simulator.ceiling.lamp import CeilingLamp, Disc
from scene_simulator.ceiling.lens import Blooming, CeilingLens
from scene_simulator.ceiling.room import CeilingRoom
from scene_simulator.errors import SceneError, check_seed
from scene_simulator.floor.camera import Disturbance, FloorCamera, FloorPhoto
from scene_simulator.floor.disturbances import FloorArea, SpecularReflection, Tape, crumbs, dust, hairs
from scene_simulator.floor.dot_floor import DotFloor, FloorDesign, generate_dot_floor
from scene_simulator.imaging.exposure import Shutter
from scene_simulator.room.box_room import Box
from scene_simulator.room.furniture import FurnishedRoom, Furnishing, furnish
from shirube_core.geometry import SE2, CameraMount, PinholeCamera
from shirube_core.waveform import Waveform

ROOM: Box = (0.0, 0.0, 0.0, 8.0, 6.0, 3.2)  # corners of the room in the map frame [m]

ROBOT_RADIUS, ROBOT_HEIGHT = 0.2, 1.3  # radius and height of the robot's bounding cylinder, mast included [m]
_START = SE2(0.9, 1.1, 0.0)
_GOALS = (SE2(5.8, 1.2, 0.0), SE2(6.4, 3.8, 0.5 * math.pi), SE2(2.2, 4.6, math.pi))
"""Each faces a wall with landmarks, 2.2 m before it."""

_MAX_SHIFT, _MAX_ROTATION = 0.1, math.radians(4.0)  # maximum random shift and rotation of start and goals [m, rad]
_LAYOUT = 11
FURNISHING = Furnishing(crates=8, tables=3, racks=0, overhangs=0)
"""Nothing is higher than a meter: it hides neither lamps nor landmarks from the mast."""

PASSAGE = 0.25  # minimum clearance between the robot and obstacles on the path to the goals [m]
_CLEARANCE = 0.6  # clearance around start and goals [m]: room to turn
CELL = 0.05  # side of the cells of `free_distances` [m]
_TRIES = 100


@dataclass(frozen=True)
class Zone:
    """A rectangle on the floor by its lower left and upper right corner [m]."""

    low: tuple[float, float]
    high: tuple[float, float]

    def contains(self, x: float, y: float) -> bool:
        """Return whether a place [m] is in it."""
        return self.low[0] <= x <= self.high[0] and self.low[1] <= y <= self.high[1]


CARPET = Zone((4.4, 0.4), (7.0, 2.0))  # a carpet hides the floor's dots
DARK = Zone((5.4, 3.0), (7.4, 4.6))  # no lamp is visible here: those above are off
COVERED = Zone((1.4, 3.8), (4.8, 5.4))  # the landmarks of the west wall are hidden by a curtain here
ZONES = {'carpet': CARPET, 'dark': DARK, 'covered': COVERED}
"""The zones by name: without floor dots, without lamps, without landmarks."""


@dataclass(frozen=True)
class MissionLayout:
    """``T_map_base`` at the start, and the goals in the order in which they are to be reached."""

    start: SE2
    goals: tuple[SE2, ...]


NOMINAL = MissionLayout(_START, _GOALS)  # start and goals as the places were taught for them


def mission_layout(seed: int) -> MissionLayout:
    """Return start and goals of a seed, each a little off the nominal pose."""
    check_seed(seed)
    rng = np.random.default_rng((seed, _LAYOUT))
    start, *goals = (_perturb(pose, rng) for pose in (_START, *_GOALS))
    return MissionLayout(start, tuple(goals))


def _perturb(pose: SE2, rng: np.random.Generator) -> SE2:
    x, y, turn = rng.uniform(-1.0, 1.0, 3).tolist()
    return SE2(pose.x + _MAX_SHIFT * x, pose.y + _MAX_SHIFT * y, pose.yaw + _MAX_ROTATION * turn)


def mission_obstacles(seed: int, layout: MissionLayout) -> FurnishedRoom:
    """Return the furnished room: the first one drawn in which all goals can be reached, or raise SceneError."""
    stops = [(pose.x, pose.y) for pose in (layout.start, *layout.goals)]
    for attempt in range(_TRIES):
        room = furnish(ROOM, FURNISHING, _TRIES * seed + attempt, stops, _CLEARANCE)
        if is_connected(room, stops):
            return room
    raise SceneError(f'no room of seed {seed} has a free path to all goals; use another seed')


def is_connected(room: FurnishedRoom, stops: list[tuple[float, float]]) -> bool:
    """Return whether the robot can drive from each of some places [m] to all others."""
    components, _ = label(free_distances(room, ROBOT_HEIGHT) > ROBOT_RADIUS + PASSAGE, structure=np.ones((3, 3)))
    found = {int(components[math.floor(y / CELL), math.floor(x / CELL)]) for x, y in stops}
    return len(found) == 1 and 0 not in found


def free_distances(room: FurnishedRoom, height: float) -> NDArray[np.float64]:
    """Return how far each cell of a grid is from what is in the room up to a height, shape (rows, columns) [m]."""
    shape = round(ROOM[4] / CELL), round(ROOM[3] / CELL)
    solid = np.pad(room.boxes.solid_cells((0.0, 0.0), CELL, shape, (0.0, height)), 1, constant_values=True)
    return np.asarray(CELL * distance_transform_edt(~solid)[1:-1, 1:-1])


DESIGN = FloorDesign(size=(ROOM[3], ROOM[4]), count=57_600, diameters=(0.004, 0.006), min_distance=0.0035)
"""1200 chips a square meter; about fifty are in view."""

BELLY_CAMERA = FloorCamera(PinholeCamera(235, 235, 150.0, 150.0, 117.0, 117.0))  # it sees 0.2 x 0.2 m from 0.13 m
BELLY_MOUNT = CameraMount()
EXPOSURE = 0.0015  # [s]
_FLOOR_SEED = 2612
_WEAR = 0.03
_CARPET_COLOUR = (0.22, 0.2, 0.3)


def surveyed_floor() -> DotFloor:
    """Return the floor as surveyed; it is always the same."""
    return generate_dot_floor(DESIGN, _FLOOR_SEED)


@dataclass(frozen=True)
class MissionFloor:
    """The floor as it is driven on: seed of wear and dirt, and the floor as surveyed before."""

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


LAMP_RADIUS = 0.12  # radius of the frosted discs [m]: 27 image rows
LAMPS = {
    1 + 4 * row + column: (x, y, ROOM[5] - 0.1)
    for row, y in enumerate((1.0, 3.0, 5.0))
    for column, x in enumerate((1.0, 3.0, 5.0, 7.0))
}
"""Place of each lamp by its ID [m]."""

DARK_LAMPS = (7, 8, 11, 12)  # IDs of those that are off

SLOW_LAMP, FAST_LAMP = 3, 10
"""IDs of the lamps that send commands: slow down before the first goal, speed up before the last one."""

CEILING_CAMERA = CeilingCamera(
    PinholeCamera(480, 384, 240.0, 240.0, 239.5, 191.5),
    Shutter(60e-6, 18.9e-6),
    CeilingLens(blooming=Blooming(glow_reach=4.0)),
)
"""A cheap camera with a rolling shutter; its exposure is too short for the dim ceiling."""

CEILING_MOUNT = CameraMount((0.0, 0.0, 1.0), (0.0, 0.0, 0.5 * math.pi))
"""Camera on the mast, looking straight up with the image's upper edge ahead."""

LAMP_RATE = 25.0  # frame rate that the lamps' waveforms are designed for [Hz]
_CLOCK_SIGMA = 20.0  # standard deviation of the lamps' clock rates [ppm]
_PHASE_STREAM = 12


def mission_ceiling(waveforms: Mapping[int, Waveform], seed: int) -> CeilingRoom:
    """Return the ceiling.

    Args:
        waveforms: waveform of each lamp, by its ID; a SceneError if one is missing.
        seed: seed of the phases and clock errors of the lamps.
    """
    missing = sorted(set(LAMPS) - set(waveforms))
    if missing:
        raise SceneError(f'lamp {missing[0]} has no waveform: give a waveform for each of {sorted(LAMPS)}')
    rng = np.random.default_rng((seed, _PHASE_STREAM))
    lamps = []
    for lamp_id, position in LAMPS.items():
        phase, offset = float(rng.uniform(0.0, 10.0)), float(rng.normal(0.0, _CLOCK_SIGMA))
        if lamp_id not in DARK_LAMPS:
            brightness = CEILING_CAMERA.brightness_for(1.0)
            lamps.append(CeilingLamp(position, Disc(LAMP_RADIUS), waveforms[lamp_id], brightness, phase, offset))
    return CeilingRoom(tuple(lamps))


def lamps_near(room: CeilingRoom, x: float, y: float) -> CeilingRoom:
    """Return the room with those lamps alone that the camera can see from a place [m]; the others take time."""
    camera = CEILING_CAMERA.intrinsics
    height = ROOM[5] - CEILING_MOUNT.xyz[2]
    reach = height * math.hypot(camera.width / camera.fx, camera.height / camera.fy) * 0.5 + 0.5
    near = tuple(lamp for lamp in room.lamps if math.hypot(lamp.xyz[0] - x, lamp.xyz[1] - y) < reach)
    return CeilingRoom(near)
