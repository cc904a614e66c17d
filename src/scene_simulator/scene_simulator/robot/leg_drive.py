"""A drive along straight legs whose corners are rounded to arcs, exact in closed form."""

import math
from collections.abc import Sequence
from dataclasses import dataclass
from itertools import pairwise

import numpy as np
from numpy.typing import ArrayLike, NDArray

from scene_simulator.errors import SceneError
from shirube_core.geometry import SE2


def arc_motion(distance: float, yaw: float) -> SE2:
    """Return the pose after an arc of a length, forward positive [m], and a yaw change [rad], from its start."""
    chord = distance * float(np.sinc(0.5 * yaw / math.pi))
    return SE2(chord * math.cos(0.5 * yaw), chord * math.sin(0.5 * yaw), yaw)


@dataclass(frozen=True)
class _Segment:
    """A leg between its corners (curvature 0) or the arc in a corner, driven at most at one speed."""

    start: SE2
    length: float
    curvature: float
    speed: float

    def pose_after(self, distance: float) -> SE2:
        """Return ``T_map_base`` at a distance from the segment's start [m]."""
        return self.start @ arc_motion(distance, self.curvature * distance)


class LegDrive:
    """A drive along legs and arcs; the robot always faces along it and is stationary at both ends.

    Attributes:
        duration: time from the start to the end, the rest at the start included [s].
    """

    def __init__(
        self, corners: ArrayLike, speeds: Sequence[float], radius: float, rest: float = 0.0, acceleration: float = 0.4
    ) -> None:
        """Plan a drive.

        Args:
            corners: array-like, shape (n, 2), the start, the corners and the end in the map frame [m].
            speeds: n - 1 speeds of the legs [m/s]; a corner is driven at the lower speed of its two legs.
            radius: corner radius [m].
            rest: pause at the start [s].
            acceleration: acceleration along the legs, where the speed changes [m/s^2].

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
        self._segments = _segments(places, speeds, radius)
        self._distances = np.cumsum([0.0, *(segment.length for segment in self._segments)])
        self._phases = _phases(self._segments, rest, acceleration)
        self.duration = float(self._phases[-1, 0])

    def pose_at(self, time: float) -> SE2:
        """Return ``T_map_base`` at a time since the start [s]; outside the drive the robot is stationary."""
        phase = max(int(np.searchsorted(self._phases[:, 0], time, side='right')) - 1, 0)
        start, distance, speed, acceleration = self._phases[phase].tolist()
        since = max(time - start, 0.0)
        distance += speed * since + 0.5 * acceleration * since**2
        segment = min(
            max(int(np.searchsorted(self._distances, distance, side='right')) - 1, 0), len(self._segments) - 1
        )
        return self._segments[segment].pose_after(distance - float(self._distances[segment]))


def _segments(places: NDArray[np.float64], speeds: Sequence[float], radius: float) -> list[_Segment]:
    """Return legs and arcs in turn."""
    legs = np.diff(places, axis=0)
    lengths, headings = np.hypot(*legs.T), np.arctan2(legs[:, 1], legs[:, 0])
    turns = [math.remainder(after - before, math.tau) for before, after in pairwise(headings.tolist())]
    tangents = np.array([0.0, *(radius * math.tan(0.5 * abs(turn)) for turn in turns), 0.0])
    straight_lengths = lengths - tangents[:-1] - tangents[1:]
    if not (straight_lengths > 0.0).all():
        raise SceneError(f'corners of radius {radius} m do not fit between legs of {lengths.min():.2f} m')
    pose = SE2(float(places[0, 0]), float(places[0, 1]), float(headings[0]))
    segments: list[_Segment] = []
    for index, straight in enumerate(straight_lengths.tolist()):
        segments.append(_Segment(pose, straight, 0.0, speeds[index]))
        if index < len(turns):
            turn = turns[index]
            slower = min(speeds[index], speeds[index + 1])
            arc = _Segment(
                segments[-1].pose_after(straight), radius * abs(turn), math.copysign(1.0 / radius, turn), slower
            )
            segments.append(arc)
            pose = arc.pose_after(arc.length)
    return segments


def _phases(segments: Sequence[_Segment], rest: float, acceleration: float) -> NDArray[np.float64]:
    """Return constant-acceleration phases, shape (n, 4): start [s], distance [m], speed [m/s], rate [m/s^2]."""
    boundary_speeds = [0.0, *(min(a.speed, b.speed) for a, b in pairwise(segments)), 0.0]
    time, distance = rest, 0.0
    phases = [(0.0, 0.0, 0.0, 0.0)]
    for segment, before, after in zip(segments, boundary_speeds[:-1], boundary_speeds[1:], strict=True):
        top = segment.speed
        rising, falling = (top - before) / acceleration, (top - after) / acceleration
        cruise = segment.length - 0.5 * (top + before) * rising - 0.5 * (top + after) * falling
        if cruise < 0.0:
            raise SceneError(f'a leg of {segment.length:.2f} m is too short to reach {top} m/s on it')
        for duration, speed, rate in (
            (rising, before, acceleration),
            (cruise / top, top, 0.0),
            (falling, top, -acceleration),
        ):
            phases.append((time, distance, speed, rate))
            time += duration
            distance += speed * duration + 0.5 * rate * duration**2
    return np.array([*phases, (time, distance, 0.0, 0.0)])
