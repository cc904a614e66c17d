"""What the benchmark of dot extraction photographs: floors, light, dirt and cameras."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass, field, replace

from scene_simulator.floor.camera import PAPER_CAMERA, Disturbance
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
from scene_simulator.floor.dot_floor import COLOURED, DARK_ON_LIGHT, LIGHT_ON_DARK, FloorDesign
from scene_simulator.imaging.sensors import Lighting, Sensor
from shirube_core.geometry import PinholeCamera

NEAR_CAMERA = PinholeCamera(1280, 1024, 1857.0, 1857.0, 639.5, 511.5)
WIDE_CAMERA = PinholeCamera(1280, 1024, 339.44, 339.44, 639.5, 511.5)


def _shadow(x: float, y: float) -> tuple[Disturbance, ...]:
    return (ShadowEdge((x, y), 0.4 + 5.0 * x),)


def _dirt(x: float, y: float) -> tuple[Disturbance, ...]:
    area = FloorArea((x - 0.1, y - 0.1), (x + 0.1, y + 0.1))
    seed = int(1e6 * (x + y))
    return (
        crumbs(area, 300.0, seed),
        dust(area, 5000.0, seed + 1),
        hairs(area, 600.0, seed + 2),
        scratches(area, 400.0, seed + 3),
    )


def _reflection(x: float, y: float) -> tuple[Disturbance, ...]:
    return (SpecularReflection((math.sin(30.0 * x) * 0.6, math.cos(30.0 * y) * 0.6), 0.08),)


def _wet(x: float, y: float) -> tuple[Disturbance, ...]:
    seed = int(1e6 * (x + y))
    return (
        WetSpot((x + 0.02, y + 0.015), 0.015, seed=seed),
        WetSpot((x - 0.02, y - 0.01), 0.01, seed=seed + 1),
    )


def _mat(x: float, y: float) -> tuple[Disturbance, ...]:
    # Covers the view up to its middle, in a direction of its own.
    direction = 50.0 * x
    ahead, across = (math.cos(direction), math.sin(direction)), (-math.sin(direction), math.cos(direction))
    middle = (x + 0.1 * ahead[0], y + 0.1 * ahead[1])
    start = (middle[0] - 0.3 * across[0], middle[1] - 0.3 * across[1])
    end = (middle[0] + 0.3 * across[0], middle[1] + 0.3 * across[1])
    return (Tape(start, end, 0.2, colour=(0.45, 0.4, 0.38)),)


@dataclass(frozen=True)
class Condition:
    """What is photographed, and how.

    Attributes:
        name: name in the table.
        design: the floor.
        camera: intrinsics.
        lighting: lamps and lens.
        sensor: noise.
        colour: whether the camera takes colours.
        blur: length of the motion during the exposure [px].
        disturbances: disturbances of the floor at the place x, y of the camera [m].
        jpeg_quality: JPEG quality, 0 for no compression.
        images: how many.
    """

    name: str
    design: FloorDesign = DARK_ON_LIGHT
    camera: PinholeCamera = PAPER_CAMERA
    lighting: Lighting = field(default_factory=Lighting)
    sensor: Sensor = field(default_factory=Sensor)
    colour: bool = False
    blur: float = 0.0
    disturbances: Callable[[float, float], tuple[Disturbance, ...]] | None = None
    jpeg_quality: int = 0
    images: int = 24


_PALE = replace(DARK_ON_LIGHT, chip_colours=((0.46, 0.56, 0.61),))
_SPARSE = replace(DARK_ON_LIGHT, count=DARK_ON_LIGHT.count // 4)
# A third as many: as many as before would cover a quarter of the floor.
_LARGE = replace(DARK_ON_LIGHT, count=DARK_ON_LIGHT.count // 3, diameters=(0.006, 0.009), min_distance=0.0036)

CONDITIONS = (
    Condition('clean'),
    Condition('gradient', lighting=Lighting(level=0.7, gradient=(0.6, -0.3), vignetting=0.4)),
    Condition('shadow edge', disturbances=_shadow),
    Condition('noise x3', sensor=Sensor(full_well=1000.0, read_noise=4.0)),
    Condition('blur 3 px', blur=3.0),
    Condition('blur 6 px', blur=6.0),
    Condition('blur 10 px', blur=10.0),
    Condition('dirt and hairs', disturbances=_dirt),
    Condition('reflection', disturbances=_reflection),
    Condition('wet spots', disturbances=_wet),
    Condition('half covered', disturbances=_mat),
    Condition('low contrast', design=_PALE),
    Condition('JPEG quality 30', jpeg_quality=30),
    Condition('3x larger dots', design=_LARGE),
    Condition('4x fewer dots', design=_SPARSE),
    Condition('light on dark', design=LIGHT_ON_DARK),
    Condition('coloured', design=COLOURED, colour=True),
    Condition('1280x1024, 0.07 mm/px', camera=NEAR_CAMERA, images=6),
    Condition('1280x1024, 0.38 mm/px', camera=WIDE_CAMERA, images=3),
)
