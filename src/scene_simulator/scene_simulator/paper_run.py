"""The paper's run (3.3): straight on, at A slower and to the right, at B to the right and faster.

The robot starts along x, turns by 90 degrees to the right about under lamp A, drives slowly along -y, turns by 90
degrees to the right about under lamp B and drives off along -x. The drive is the one that the commands ask
for; the caller chooses the waveforms.
"""

from __future__ import annotations

from collections.abc import Sequence

from scene_simulator.ceiling_camera import CeilingCamera
from scene_simulator.ceiling_room import PAPER_LAMPS, paper_room
from scene_simulator.distractor_lights import distractors
from scene_simulator.lamp_drive import LampDrive
from scene_simulator.lamp_shape import LampShape
from scene_simulator.leg_drive import LegDrive
from shirube_core.waveform import Waveform

LAMP_A, LAMP_B = 3, 2
"""Indices into ``PAPER_LAMPS``: A at (1.8, 1.8), B at (1.8, 0)."""

_OFFSET = 0.05
"""Lateral distance between the legs and the lamps [m]."""

_CORNER_RADIUS = 0.3


def paper_run(
    waveforms: Sequence[Waveform],
    speed: float = 0.25,
    slow_speed: float = 0.125,
    camera: CeilingCamera | None = None,
    seed: int = 0,
    rest: float = 3.0,
    shape: LampShape | None = None,
) -> LampDrive:
    """Return the run in the paper's dim room, with other lights about.

    With a rest of 3 s A is in view for the first 9 s before the robot reaches it: time for two command packets of
    30 bit/s.

    Args:
        waveforms: what the four lamps of ``PAPER_LAMPS`` send.
        speed: speed before A and after B [m/s].
        slow_speed: speed between A and B [m/s].
        camera: the camera, by default the paper's with a global shutter and 0.5 ms of exposure.
        seed: random seed.
        rest: pause at the start [s].
        shape: shape of the lamps, by default the paper's panels of 8 x 8 LEDs.

    Raises:
        SceneError: not four waveforms, or speeds that are not positive.
    """
    chosen = camera or CeilingCamera()
    brightness = chosen.brightness_for(1.0)
    room = paper_room(waveforms, shape, brightness).with_ambient_light(0.03 * brightness, seed=seed)
    a, b = PAPER_LAMPS[LAMP_A], PAPER_LAMPS[LAMP_B]
    x = a[0] - _OFFSET
    corners = [(-0.1, a[1] - _OFFSET), (x, a[1] - _OFFSET), (x, b[1] + _OFFSET), (-1.0, b[1] + _OFFSET)]
    route = LegDrive(corners, [speed, slow_speed, speed], _CORNER_RADIUS, rest)
    return LampDrive(room.with_lights(distractors(brightness)), route, chosen, seed=seed)
