"""What makes a picture of the floor hard: light, dirt, motion, other chips, compression, cameras."""

import math
from collections.abc import Callable
from dataclasses import dataclass, field, replace

import cv2
import numpy as np
from _floor_photographs import CAMERA, MOUNT

from scene_simulator.floor.camera import PAPER_CAMERA, Disturbance, FloorCamera, FloorPhoto
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
from scene_simulator.floor.dot_floor import COLOURED, DARK_ON_LIGHT, LIGHT_ON_DARK, DotFloor, FloorDesign
from scene_simulator.imaging.sensors import Lighting, Sensor
from shirube_core.geometry import SE2, PinholeCamera

Disturbances = Callable[[SE2, np.random.Generator], tuple[Disturbance, ...]]

NEAR_CAMERA = PinholeCamera(1280, 1024, 1857.0, 1857.0, 639.5, 511.5)
WIDE_CAMERA = PinholeCamera(1280, 1024, 339.44, 339.44, 639.5, 511.5)

FEWER = replace(DARK_ON_LIGHT, count=DARK_ON_LIGHT.count // 4)
LARGER = replace(DARK_ON_LIGHT, diameters=(0.006, 0.009), min_distance=0.0036)
PALE = replace(DARK_ON_LIGHT, chip_colours=((0.50, 0.60, 0.65),))

_MAT, _PAPER = (0.14, 0.13, 0.12), (0.88, 0.90, 0.90)


def shadow(pose: SE2, rng: np.random.Generator) -> tuple[Disturbance, ...]:
    """Place a shadow's edge near the middle of the view."""
    point = pose.transform(rng.uniform(-0.015, 0.015, (1, 2)))[0]
    return (ShadowEdge((point[0], point[1]), rng.uniform(0.0, math.tau), rng.uniform(0.4, 0.7)),)


def reflections(_pose: SE2, rng: np.random.Generator) -> tuple[Disturbance, ...]:
    """Mirror four lamps."""
    places = rng.uniform(-0.8, 0.8, (4, 2))
    return tuple(SpecularReflection((u, v), rng.uniform(0.05, 0.12), rng.uniform(1.0, 1.5)) for u, v in places)


def cover_half(pose: SE2, rng: np.random.Generator) -> tuple[Disturbance, ...]:
    """Cover the half of the view beyond a line through its middle, with a dark mat or white paper."""
    at_edge = SE2(pose.x, pose.y, rng.uniform(-math.pi, math.pi))
    start, end = at_edge.transform([(-0.2, 0.1), (0.2, 0.1)])
    return (Tape((start[0], start[1]), (end[0], end[1]), 0.2, _MAT if rng.uniform() < 0.5 else _PAPER),)


def wet(pose: SE2, rng: np.random.Generator) -> tuple[Disturbance, ...]:
    """Spill three puddles with bright rims into the view."""
    centres = pose.transform(rng.uniform(-0.04, 0.04, (3, 2)))
    return tuple(
        WetSpot((x, y), rng.uniform(0.008, 0.02), 0.35, 0.9, int(rng.integers(1000)), rim_shine=0.9) for x, y in centres
    )


def dirt(pose: SE2, rng: np.random.Generator) -> tuple[Disturbance, ...]:
    """Strew crumbs, dust, hairs and scratches."""
    area = FloorArea((pose.x - 0.1, pose.y - 0.1), (pose.x + 0.1, pose.y + 0.1))
    seed = int(rng.integers(1_000_000))
    strewn = (crumbs, 300.0), (dust, 5000.0), (hairs, 600.0), (scratches, 400.0)
    return tuple(strew(area, density, seed + k) for k, (strew, density) in enumerate(strewn))


@dataclass(frozen=True)
class HardCondition:
    """What is photographed, and how.

    Attributes:
        name: name in the table.
        design: the floor.
        disturbances: disturbances of the floor at a pose.
        blur: length of the motion during the exposure [px].
        jpeg_quality: JPEG quality, None for no compression.
        camera: intrinsics; the demo's lens bends.
        lighting: lamps and lens.
        sensor: noise.
    """

    name: str
    design: FloorDesign = DARK_ON_LIGHT
    disturbances: Disturbances = lambda _pose, _rng: ()
    blur: float = 0.0
    jpeg_quality: int | None = None
    camera: PinholeCamera = CAMERA
    lighting: Lighting = field(default_factory=Lighting)
    sensor: Sensor = field(default_factory=Sensor)

    @property
    def photographer(self) -> FloorCamera:
        """The camera that takes the pictures."""
        return FloorCamera(self.camera, self.lighting, self.sensor, self.design is COLOURED)

    def photograph(self, floor: DotFloor, pose: SE2, rng: np.random.Generator) -> FloorPhoto:
        """Take a picture of a floor of this design."""
        course = rng.uniform(-math.pi, math.pi)
        pixel = MOUNT.xyz[2] / self.camera.fx
        way = pixel * self.blur * np.linspace(-0.5, 0.5, 4 * round(self.blur) + 1)
        poses = [SE2(pose.x + s * math.cos(course), pose.y + s * math.sin(course), pose.yaw) for s in way]
        photo = self.photographer.photograph(floor, poses, MOUNT, self.disturbances(pose, rng), rng)
        if self.jpeg_quality is None:
            return photo
        _, data = cv2.imencode('.jpg', photo.image, [cv2.IMWRITE_JPEG_QUALITY, self.jpeg_quality])
        image = np.asarray(cv2.imdecode(data, cv2.IMREAD_UNCHANGED), dtype=np.uint8)
        return replace(photo, image=image)


CONDITIONS = (
    HardCondition('clean'),
    HardCondition('shadow edge', disturbances=shadow),
    HardCondition('reflections', disturbances=reflections),
    HardCondition('motion blur 3 px', blur=3.0),
    HardCondition('motion blur 6 px', blur=6.0),
    HardCondition('motion blur 10 px', blur=10.0),
    HardCondition('half covered', disturbances=cover_half),
    HardCondition('wet spots', disturbances=wet),
    HardCondition('4x fewer dots', design=FEWER),
    HardCondition('dots 3x larger', design=LARGER),
    HardCondition('low contrast', design=PALE),
    HardCondition('JPEG at quality 30', jpeg_quality=30),
)

FOR_DETECTORS = (
    *(replace(condition, camera=PAPER_CAMERA) for condition in CONDITIONS),
    HardCondition('gradient', lighting=Lighting(0.7, (0.6, -0.3), vignetting=0.4), camera=PAPER_CAMERA),
    HardCondition('noise x3', sensor=Sensor(full_well=1000.0, read_noise=4.0), camera=PAPER_CAMERA),
    HardCondition('dirt and hairs', disturbances=dirt, camera=PAPER_CAMERA),
    HardCondition('light on dark', design=LIGHT_ON_DARK, camera=PAPER_CAMERA),
    HardCondition('coloured', design=COLOURED, camera=PAPER_CAMERA),
    HardCondition('1280x1024, 0.07 mm/px', camera=NEAR_CAMERA),
    HardCondition('1280x1024, 0.38 mm/px', camera=WIDE_CAMERA),
)
