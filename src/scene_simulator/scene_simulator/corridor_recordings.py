"""Recorded drives in one corridor: one teach run and repeat runs with changed views."""

from __future__ import annotations

import math
from dataclasses import dataclass, replace

from scene_simulator.corridor_generator import CorridorDesign, corridor
from scene_simulator.corridor_light import CorridorLight
from scene_simulator.corridor_occluder import Person
from scene_simulator.corridor_scene import CorridorScene
from scene_simulator.corridor_surface import facing_wall
from scene_simulator.errors import SceneError
from scene_simulator.leg_drive import LegDrive
from scene_simulator.stereo_drive import StereoDrive
from scene_simulator.stereo_rig import StereoRig
from shirube_core.geometry import SE2

TAUGHT_POSE = SE2(-3.0, 0.0, 0.0)
"""Taught pose ``T_map_place``."""

_RUN_UP, _SPEED, _REST = 1.0, 0.5, 0.5
"""Distance to the goal [m], speed [m/s], pause before the start [s]."""

SECONDS = 5.0
"""Duration of a drive; the robot is stationary at its goal for the last second [s]."""


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


def make_corridor_drive(
    run: str, design: CorridorDesign | None = None, rig: StereoRig | None = None
) -> StereoDrive:
    """Return one of ``RUNS``; the meter readings differ between runs.

    Raises:
        SceneError: there is no such run.
    """
    if run not in RUNS:
        raise SceneError(f'there is no run {run!r}: choose one of {", ".join(RUNS)}')
    chosen, number = design or CorridorDesign(), list(RUNS).index(run)
    scene = RUNS[run].apply_change(corridor(replace(chosen, needles=number)))
    return StereoDrive(scene, RUNS[run].route, rig or StereoRig(), seed=number)
