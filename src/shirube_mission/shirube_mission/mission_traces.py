"""Everything that the report of a mission draws, as plain numbers."""

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
    """A map of the planner.

    Attributes:
        corner: x and y of its lower left corner in the map frame [m].
        resolution: side of a cell [m].
        shape: rows along y and columns along x.
        cells: row by row: -1 unknown, 0 free to 100 occupied.
    """

    corner: tuple[float, float]
    resolution: float
    shape: tuple[int, int]
    cells: Sequence[int]


@dataclass(frozen=True)
class TrustCount:
    """How many poses of a source have met a verdict of the arbiter so far.

    Attributes:
        time: of the count [s].
        source: name of the localizer.
        verdict: of the arbiter, in its words.
        count: of poses since the start.
    """

    time: float
    source: str
    verdict: str
    count: int


@dataclass(frozen=True)
class MissionTraces:
    """What happened, over time.

    Attributes:
        layout: start and goals.
        boxes: what stands in the room.
        truth: the true poses, every step.
        clearance: the robot's room in each step [m].
        poses: of each localizer, of the arbiter and of the wheels' odometry (which begins at 0), by name.
        legs: when each goal was given, and when the robot was done with it [s].
        trust: the arbiter's counts, once a second.
        map: the planner's last one.
        pace: simulated time and the time it took since the start of the drive [s], about once a second.
        cpu: processor time of each process during the drive [s].
        rates: pictures that each camera was to take in a second, and pictures that it showed in a simulated one.
    """

    layout: MissionLayout
    boxes: tuple[Box, ...]
    truth: Sequence[StampedNumbers]
    clearance: Sequence[float]
    poses: Mapping[str, Sequence[StampedNumbers]]
    legs: Sequence[tuple[float, float]]
    trust: Sequence[TrustCount] = ()
    map: GridMap | None = None
    pace: Sequence[tuple[float, float]] = ()
    cpu: Mapping[str, float] = field(default_factory=dict)
    rates: Mapping[str, tuple[float, float]] = field(default_factory=dict)

    def as_json(self) -> str:
        """Return everything as JSON, to micrometres and microseconds."""
        return json.dumps(
            json.loads(json.dumps(asdict(self)), parse_float=lambda text: round(float(text), 6))
        )
