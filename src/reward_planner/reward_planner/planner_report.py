"""Diagnostics of the node: state of the controller, counts of frames, points and poses."""

from __future__ import annotations

from collections import Counter
from collections.abc import Callable
from typing import Any

from reward_planner.core.driving.drive import Drive, DriveState
from reward_planner.core.mapping.pose_trail import PoseVerdict
from reward_planner.core.navigator import MappedFrame, Navigator
from shirube_ros.diagnostics import Level, Status
from shirube_ros.stamp_groups import StampGroups


class PlannerReport:
    """Collects the state of the controller and counters."""

    def __init__(self, navigator: Navigator, now: Callable[[], float], frame_period_max: float) -> None:
        """Start without counts.

        Args:
            navigator: source of map, pose and route counters.
            now: current time [s], 0 before simulated time starts.
            frame_period_max: time without a mapped frame after which the map is stale [s].
        """
        self._navigator, self._now, self._frame_period_max = navigator, now, frame_period_max
        self._waits_since: float | None = None
        self._groups_before = 0
        self._drive: Drive | None = None
        self._frames = 0
        self._points: Counter[str] = Counter()
        self._groups: StampGroups[Any] | None = None

    def watch(self, groups: StampGroups[Any]) -> None:
        """Report images that were dropped by the synchronizer, too."""
        self._groups = groups

    def add_frame(self, frame: MappedFrame) -> None:
        """Count a mapped frame."""
        self._frames += 1
        self._waits_since = self._now()
        self._groups_before = 0 if self._groups is None else self._groups.formed
        self._points.update(frame.tally._asdict())

    def add_drive(self, drive: Drive) -> None:
        """Set the latest output of the drive controller."""
        self._drive = drive

    def status(self) -> Status:
        """Return the diagnostic status."""
        navigator = self._navigator
        values = {'frames in the map': str(self._frames)}
        values |= {f'frames dropped: {why.value}': str(n) for why, n in navigator.frames.dropped.items()}
        if self._groups is not None:
            values['images dropped: no others with the same stamp'] = str(self._groups.dropped)
        values |= {f'points {kind.replace("_", " ")}': str(n) for kind, n in self._points.items() if n}
        values |= {
            f'poses: {verdict.value}': str(n)
            for verdict, n in navigator.verdicts.items()
            if verdict is not PoseVerdict.TAKEN
        }
        values['map [MB]'] = f'{navigator.mapper.map.bytes / 1e6:.2f}'
        if navigator.mapper.map.refused:
            values['cells rejected, the map is full'] = str(navigator.mapper.map.refused)
        keeper = navigator.pilot.keeper
        if keeper is not None:
            values['routes taken'] = str(keeper.plans)
        is_well = self._drive is None or not self._drive.state.needs_people
        does = DriveState.IDLE.value if self._drive is None else self._drive.detail
        late = self._what_is_late()
        level = Level.OK if is_well and late is None else Level.WARN
        return Status(level, does if late is None else f'{does}; {late}', values)

    def _what_is_late(self) -> str | None:
        """Return why no frame was mapped for too long, None if one was."""
        now = self._now()
        if now <= 0.0:
            return None
        if self._waits_since is None or now < self._waits_since:
            self._waits_since = now
        waits = now - self._waits_since
        if waits <= self._frame_period_max:
            return None
        line = f'no frame mapped for {waits:.1f} s'
        if self._groups is None or self._groups.formed > self._groups_before:
            return line
        if self._groups.lacking:
            return f'{line}: no images of {" and ".join(self._groups.lacking)}; check the topics'
        return f'{line}: the stamps of the images differ; synchronize the cameras'
