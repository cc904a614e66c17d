"""Kidnapping in the mission: a person carries the standing robot to another place, which the wheels do not notice."""

import math
from typing import Any

from motor_bridge.emulator.emulated_controller import EmulatedController
from shirube_core.geometry import SE2

KIDNAPPING = SE2(0.3, 0.2, 0.5 * math.pi)
"""Where the robot is put, seen from where it stands: within the free space around a goal."""

RECOVERED_WITHIN, RECOVERY_TIME = 0.02, 20.0
"""Error of the fused pose below which the robot has recovered [m], and the timeout [s]."""


class CarriedController(EmulatedController):
    """An emulated robot that can be carried away; arguments as for `EmulatedController`."""

    def __init__(self, *arguments: Any, **more: Any) -> None:
        """Start as it would without being carried."""
        super().__init__(*arguments, **more)
        self._carried = [(-math.inf, SE2(0.0, 0.0, 0.0))]

    @property
    def T_world_base(self) -> SE2:  # noqa: N802 the field's name for it
        """True pose now."""
        return self.pose_at(self.time)

    def pose_at(self, time: float) -> SE2:
        """Return ``T_world_base`` at a time [s], before or after it was carried."""
        displacement = next(each for since, each in reversed(self._carried) if time >= since)
        return displacement @ super().pose_at(time)

    def carry_to(self, T_world_base: SE2) -> None:
        """Put the robot somewhere else; its wheels do not turn."""
        self._carried.append((self.time, T_world_base @ super().pose_at(self.time).inverse()))
