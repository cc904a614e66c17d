"""The mission's ceiling: lamps that send their IDs, two that send commands, four that are off."""

import math
from collections.abc import Mapping

import numpy as np

from scene_simulator.ceiling.camera import CeilingCamera
from scene_simulator.ceiling.lamp import CeilingLamp, Disc
from scene_simulator.ceiling.lens import Blooming, CeilingLens
from scene_simulator.ceiling.room import CeilingRoom
from scene_simulator.errors import SceneError
from scene_simulator.imaging.exposure import Shutter
from scene_simulator.mission.layout import ROOM
from shirube_core.geometry import CameraMount, PinholeCamera
from shirube_core.waveform import Waveform

LAMP_RADIUS = 0.12
"""Radius of the frosted discs [m]: 27 image rows."""

LAMPS = {
    1 + 4 * row + column: (x, y, ROOM[5] - 0.1)
    for row, y in enumerate((1.0, 3.0, 5.0))
    for column, x in enumerate((1.0, 3.0, 5.0, 7.0))
}
"""Place of each lamp by its ID [m]."""

DARK_LAMPS = (7, 8, 11, 12)
"""IDs of those that are off."""

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

LAMP_RATE = 25.0
"""Frame rate that the lamps' waveforms are designed for [Hz]."""

_CLOCK_SIGMA = 20.0
"""Standard deviation of the lamps' clock rates [ppm]."""

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
