"""Time series for the report of a mission."""

from __future__ import annotations

import json
from collections.abc import Mapping, Sequence
from dataclasses import asdict, dataclass, field

from scene_simulator.box_room import Box
from scene_simulator.mission_layout import MissionLayout

StampedNumbers = tuple[float, float, float, float]
"""Time [s], x [m], y [m], yaw [rad]."""


@dataclass(frozen=True)
class GridMap:
    """An occupancy grid of the planner.

    Attributes:
        corner: x and y of the lower left corner in the map frame [m].
        resolution: cell size [m].
        shape: number of rows (y) and columns (x).
        cells: occupancy in row-major order: -1 unknown, 0 free to 100 occupied.
    """

    corner: tuple[float, float]
    resolution: float
    shape: tuple[int, int]
    cells: Sequence[int]


@dataclass(frozen=True)
class StatusCount:
    """Cumulative number of poses of a source with a measurement status of the arbiter.

    Attributes:
        time: time of the count [s].
        source: name of the localizer.
        verdict: measurement status, as in the arbiter's diagnostics.
        count: number of poses since the start.
    """

    time: float
    source: str
    verdict: str
    count: int


@dataclass(frozen=True)
class MissionTraces:
    """Time series of a mission.

    Attributes:
        layout: start and goals.
        boxes: obstacles in the room.
        truth: true poses, every step.
        clearance: clearance around the robot in each step [m].
        poses: poses of each localizer, of the arbiter and of wheel odometry (which starts at 0), by name.
        legs: start and end time of each goal [s].
        trust: measurement status counts of the arbiter, once a second.
        map: last map of the planner.
        pace: simulated time and wall time since the start of the drive [s], about once a second.
        cpu: CPU time of each process during the drive [s].
        rates: nominal image rate of each camera, and published images per simulated second [1/s].
    """

    layout: MissionLayout
    boxes: tuple[Box, ...]
    truth: Sequence[StampedNumbers]
    clearance: Sequence[float]
    poses: Mapping[str, Sequence[StampedNumbers]]
    legs: Sequence[tuple[float, float]]
    trust: Sequence[StatusCount] = ()
    map: GridMap | None = None
    pace: Sequence[tuple[float, float]] = ()
    cpu: Mapping[str, float] = field(default_factory=dict)
    rates: Mapping[str, tuple[float, float]] = field(default_factory=dict)

    def as_json(self) -> str:
        """Return the traces as JSON text, with six decimals."""
        return json.dumps(
            json.loads(json.dumps(asdict(self)), parse_float=lambda text: round(float(text), 6))
        )
