"""A drive along straight legs whose corners are rounded to arcs, exact in closed form, and the tilt of the body."""

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from itertools import pairwise

import numpy as np
from numpy.typing import ArrayLike, NDArray
from scipy.spatial.transform import Rotation

from scene_simulator.errors import SceneError
from shirube_core.geometry import SE2, CameraMount, matrix_from_rpy

_FREQUENCIES = (0.07, 0.19, 0.43)  # frequencies of the oscillation; each motion has its own phase [Hz]


@dataclass(frozen=True)
class Suspension:
    """Slow motion of the body about the point of ``base_link`` on the floor.

    Attributes:
        heave: greatest height above or below rest [m].
        tilt: greatest tilt [rad].
        seed: seed of the phases.
    """

    heave: float = 0.0026
    tilt: float = math.radians(1.0)
    seed: int = 0

    def motion_at(self, time: float) -> NDArray[np.float64]:
        """Return heave [m], roll and pitch [rad] at a time [s], shape (3,)."""
        phases = np.random.default_rng(self.seed).uniform(0.0, math.tau, (3, len(_FREQUENCIES)))
        oscillation = np.sin(math.tau * np.array(_FREQUENCIES) * time + phases).mean(axis=1)
        return np.asarray(oscillation * (self.heave, self.tilt / math.sqrt(2.0), self.tilt / math.sqrt(2.0)))

    def mount_at(self, time: float, mount_at_rest: CameraMount) -> CameraMount:
        """Return where the camera is at a time [s], given its pose in ``base_link``: see ``apply_body_motion``.

        The body turns about ``base_link``, whose place and heading on the floor are the robot's pose; so a
        camera that looks straight down at ``base_link`` keeps looking there.
        """
        return apply_body_motion(mount_at_rest, *(float(part) for part in self.motion_at(time)))


def apply_body_motion(mount_at_rest: CameraMount, heave: float, roll: float, pitch: float) -> CameraMount:
    """Return where the camera is when the body has heaved [m] and turned [rad] about ``base_link``, pitch after roll.

    The returned pose is in the frame of the floor under ``base_link``: upright, with the robot's heading.
    """
    turn = matrix_from_rpy((roll, pitch, 0.0))
    x, y, z = turn @ mount_at_rest.xyz + (0.0, 0.0, heave)
    rpy = Rotation.from_matrix(turn @ mount_at_rest.rotation).as_euler('xyz')
    return CameraMount((float(x), float(y), float(z)), (float(rpy[0]), float(rpy[1]), float(rpy[2])))


@dataclass(frozen=True)
class TiltErrors:
    """Standard deviations of roll and pitch: constant error of a run, and noise of a reading [rad]."""

    bias: float = math.radians(0.05)
    noise: float = math.radians(0.03)


@dataclass(frozen=True)
class TiltReading:
    """Fixed-axis roll and pitch of the body [rad] at a time [s]."""

    time: float
    roll: float
    pitch: float


def simulate_tilt(
    tilt_at: Callable[[float], tuple[float, float]],
    times: Sequence[float],
    errors: TiltErrors,
    rng: np.random.Generator,
) -> list[TiltReading]:
    """Return readings of the tilt.

    Args:
        tilt_at: gives the true roll and pitch at a time [s].
        times: when the unit is read [s].
        errors: its errors.
        rng: source of bias and noise.
    """
    bias = errors.bias * rng.standard_normal(2)
    true = np.array([tilt_at(time) for time in times]).reshape(-1, 2)
    read = true + bias + errors.noise * rng.standard_normal(true.shape)
    return [TiltReading(time, float(roll), float(pitch)) for time, (roll, pitch) in zip(times, read, strict=True)]


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
    """Legs and arcs, the robot faces along them; ``duration`` [s] includes the rest at the start."""

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
