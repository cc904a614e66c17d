"""What the node says in the diagnostics: what the robot does, how much it sees, what was dropped."""

from __future__ import annotations

from collections import Counter
from typing import Any

from reward_planner.core.driving.drive import Drive, DriveState
from reward_planner.core.mapping.pose_trail import PoseVerdict
from reward_planner.core.navigator import MappedFrame, Navigator
from shirube_ros.diagnostics import Level, Status
from shirube_ros.stamp_groups import StampGroups


class PlannerReport:
    """Remembers what the robot did last, and counts."""

    def __init__(self, navigator: Navigator) -> None:
        """Start without counts; ``navigator`` is asked for the rest."""
        self._navigator = navigator
        self._drive: Drive | None = None
        self._frames = 0
        self._points: Counter[str] = Counter()
        self._groups: StampGroups[Any] | None = None

    def watch(self, groups: StampGroups[Any]) -> None:
        """Count the images that find no partners, too."""
        self._groups = groups

    def add_frame(self, frame: MappedFrame) -> None:
        """Take a frame that is in the map."""
        self._frames += 1
        self._points.update(frame.tally._asdict())

    def add_drive(self, drive: Drive) -> None:
        """Take what the robot does now."""
        self._drive = drive

    def status(self) -> Status:
        """Return the state of now."""
        navigator = self._navigator
        values = {'frames in the map': str(self._frames)}
        values |= {f'frames dropped: {why.value}': str(n) for why, n in navigator.frames.dropped.items()}
        if self._groups is not None:
            values['images dropped: others of their time did not come'] = str(self._groups.dropped)
        values |= {f'points {kind.replace("_", " ")}': str(n) for kind, n in self._points.items() if n}
        values |= {
            f'poses: {verdict.value}': str(n)
            for verdict, n in navigator.verdicts.items()
            if verdict is not PoseVerdict.TAKEN
        }
        values['map [MB]'] = f'{navigator.mapper.map.bytes / 1e6:.2f}'
        if navigator.mapper.map.refused:
            values['cells refused, the map is full'] = str(navigator.mapper.map.refused)
        keeper = navigator.pilot.keeper
        if keeper is not None:
            values['routes taken'] = str(keeper.plans)
        if self._drive is None:
            return Status(Level.OK, DriveState.IDLE.value, values)
        level = Level.WARN if self._drive.state.needs_people else Level.OK
        return Status(level, self._drive.detail, values)
