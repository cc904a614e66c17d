"""A drive along straight legs whose corners are rounded to arcs, exact in closed form."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from itertools import pairwise

import numpy as np
from numpy.typing import ArrayLike, NDArray

from scene_simulator.arc_motion import arc_motion
from scene_simulator.scene_error import SceneError
from shirube_geometry import PlanarPose


@dataclass(frozen=True)
class _Section:
    """A leg between its corners (curvature 0) or the arc in a corner, driven at most at one speed."""

    start: PlanarPose
    length: float
    curvature: float
    speed: float

    def pose_after(self, way: float) -> PlanarPose:
        """Return ``T_map_base`` after a way from the section's start [m]."""
        return self.start @ arc_motion(way, self.curvature * way)


class LegDrive:
    """A drive along legs and arcs; the robot always looks along it and stands at both ends.

    Attributes:
        duration: time from the start to the end, the rest at the start included [s].
    """

    def __init__(
        self,
        corners: ArrayLike,
        speeds: Sequence[float],
        radius: float,
        rest: float = 0.0,
        acceleration: float = 0.4,
    ) -> None:
        """Plan a drive.

        Args:
            corners: array-like, shape (n, 2), the start, the corners and the end in the map frame [m].
            speeds: n - 1 speeds of the legs [m/s]; a corner is driven at the lower speed of its two legs.
            radius: of the arcs in the corners [m].
            rest: how long the robot stands at the start [s].
            acceleration: along the legs, whose speed changes at their ends [m/s^2].

        Raises:
            SceneError: other numbers of corners and speeds, numbers that are not positive, legs too short.
        """
        places = np.asarray(corners, dtype=np.float64)
        if places.ndim != 2 or places.shape[1] != 2 or len(places) < 2 or len(speeds) != len(places) - 1:
            raise SceneError(f'a drive of {len(speeds)} legs needs one corner more, not {len(places)}')
        numbers = np.array([*speeds, radius, acceleration])
        if not (np.isfinite(places).all() and np.isfinite(numbers).all() and (numbers > 0.0).all()):
            raise SceneError('a drive needs finite corners and speeds, radius and acceleration above zero')
        if not 0.0 <= rest < math.inf:
            raise SceneError(f'the robot rests for {rest} s: give 0 or more')
        self._sections = _sections(places, speeds, radius)
        self._ways = np.cumsum([0.0, *(section.length for section in self._sections)])
        self._phases = _phases(self._sections, rest, acceleration)
        self.duration = float(self._phases[-1, 0])

    def pose_at(self, time: float) -> PlanarPose:
        """Return ``T_map_base`` at a time since the start [s]; outside the drive the robot stands."""
        phase = max(int(np.searchsorted(self._phases[:, 0], time, side='right')) - 1, 0)
        start, way, speed, acceleration = self._phases[phase].tolist()
        since = max(time - start, 0.0)
        way += speed * since + 0.5 * acceleration * since**2
        section = min(
            max(int(np.searchsorted(self._ways, way, side='right')) - 1, 0), len(self._sections) - 1
        )
        return self._sections[section].pose_after(way - float(self._ways[section]))


def _sections(places: NDArray[np.float64], speeds: Sequence[float], radius: float) -> list[_Section]:
    """Return legs and arcs in turn."""
    legs = np.diff(places, axis=0)
    lengths, headings = np.hypot(*legs.T), np.arctan2(legs[:, 1], legs[:, 0])
    turns = [math.remainder(after - before, math.tau) for before, after in pairwise(headings.tolist())]
    tangents = np.array([0.0, *(radius * math.tan(0.5 * abs(turn)) for turn in turns), 0.0])
    straights = lengths - tangents[:-1] - tangents[1:]
    if not (straights > 0.0).all():
        raise SceneError(f'corners of radius {radius} m do not fit between legs of {lengths.min():.2f} m')
    pose = PlanarPose(float(places[0, 0]), float(places[0, 1]), float(headings[0]))
    sections: list[_Section] = []
    for index, straight in enumerate(straights.tolist()):
        sections.append(_Section(pose, straight, 0.0, speeds[index]))
        if index < len(turns):
            turn = turns[index]
            slower = min(speeds[index], speeds[index + 1])
            arc = _Section(
                sections[-1].pose_after(straight),
                radius * abs(turn),
                math.copysign(1.0 / radius, turn),
                slower,
            )
            sections.append(arc)
            pose = arc.pose_after(arc.length)
    return sections


def _phases(sections: Sequence[_Section], rest: float, acceleration: float) -> NDArray[np.float64]:
    """Return the phases of even acceleration, shape (n, 4): start [s], way [m], speed [m/s], acceleration [m/s^2]."""
    meetings = [0.0, *(min(a.speed, b.speed) for a, b in pairwise(sections)), 0.0]
    time, way = rest, 0.0
    phases = [(0.0, 0.0, 0.0, 0.0)]
    for section, before, after in zip(sections, meetings[:-1], meetings[1:], strict=True):
        top = section.speed
        rising, falling = (top - before) / acceleration, (top - after) / acceleration
        cruise = section.length - 0.5 * (top + before) * rising - 0.5 * (top + after) * falling
        if cruise < 0.0:
            raise SceneError(f'a leg of {section.length:.2f} m is too short to reach {top} m/s on it')
        for duration, speed, rate in (
            (rising, before, acceleration),
            (cruise / top, top, 0.0),
            (falling, top, -acceleration),
        ):
            phases.append((time, way, speed, rate))
            time += duration
            way += speed * duration + 0.5 * rate * duration**2
    return np.array([*phases, (time, way, 0.0, 0.0)])
