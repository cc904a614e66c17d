"""A robot's drive over the floor: a smooth route within limits, its true pose at any time, and wheel odometry."""

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from itertools import pairwise
from typing import ClassVar, Protocol

import numpy as np
from numpy.typing import NDArray
from scipy.interpolate import CubicHermiteSpline, CubicSpline

from scene_simulator.errors import SceneError
from scene_simulator.robot.leg_drive import Suspension, TiltErrors, TiltReading, arc_motion, simulate_tilt
from shirube_core.geometry import SE2


@dataclass(frozen=True)
class WheelErrors:
    """A drive and its errors. The default drifts by about 2 % of the distance and 1 degree a metre.

    Attributes:
        separation: distance between the wheels [m].
        tick: wheel travel per encoder tick [m].
        left_scale: measured travel of the left wheel relative to the true travel.
        right_scale: the same of the right wheel.
        slip: standard deviation of a wheel's travel after one metre [m]; it grows with the square root of the distance.
    """

    separation: float = 0.3
    tick: float = 0.00008
    left_scale: float = 1.0174
    right_scale: float = 1.0226
    slip: float = 0.001


@dataclass(frozen=True)
class WheelReading:
    """A reading of the wheel odometry.

    Attributes:
        time: [s].
        pose: ``T_odom_base``.
        forward: mean speed since the last reading [m/s].
        yaw_rate: mean yaw rate since the last reading [rad/s].
    """

    time: float
    pose: SE2
    forward: float
    yaw_rate: float


def simulate_wheel_readings(
    pose_at: Callable[[float], SE2], seconds: float, period: float, errors: WheelErrors, rng: np.random.Generator
) -> list[WheelReading]:
    """Return the readings of the first seconds of a drive, one each period [s]; ``pose_at`` gives ``T_map_base``."""
    times = np.arange(0.0, seconds, period).tolist()
    poses = simulate_odometry([pose_at(time) for time in times], errors, rng)
    steps = [before.inverse() @ after for before, after in zip([poses[0], *poses], poses, strict=False)]
    return [
        WheelReading(time, pose, step.x / period, step.yaw / period)
        for time, pose, step in zip(times, poses, steps, strict=True)
    ]


def simulate_odometry(poses: Sequence[SE2], errors: WheelErrors, rng: np.random.Generator) -> list[SE2]:
    """Return ``T_odom_base``, the first one zero, at the instants at which the encoders are read.

    There is little motion between two true poses ``T_map_base``; the source of randomness is that of the slip.
    """
    scales = np.array([errors.left_scale, errors.right_scale])
    ways = ticks = np.zeros(2)
    odometry = [SE2(0.0, 0.0, 0.0)]
    for before, after in pairwise(poses):
        true_ways = _wheel_distances(before.inverse() @ after, errors.separation)
        ways = ways + scales * true_ways + rng.normal(size=2) * errors.slip * np.sqrt(np.abs(true_ways))
        read = np.floor(ways / errors.tick)
        left, right = (float(way) for way in (read - ticks) * errors.tick)
        ticks = read
        odometry.append(odometry[-1] @ arc_motion(0.5 * (left + right), (right - left) / errors.separation))
    return odometry


def _wheel_distances(motion: SE2, separation: float) -> NDArray[np.float64]:
    """Return how far the left and the right wheel roll in a motion along an arc, shape (2,) [m]."""
    half = 0.5 * motion.yaw
    way = math.hypot(motion.x, motion.y) * math.copysign(1.0, motion.x) / np.sinc(half / math.pi)
    return np.array([way - half * separation, way + half * separation])


class Route(Protocol):
    """Where the robot truly is."""

    def pose_at(self, time: float) -> SE2:
        """Return ``T_map_base`` at a time [s]."""


class SensorDrive:
    """What a drive on a suspension records besides pictures; for subclasses with these fields.

    Attributes:
        route: the true drive, a `LegDrive` or a `RobotDrive`.
        suspension: heave and tilt of the body.
        wheels: errors of the odometry.
        tilt: errors of the inertial unit.
        seed: seed of noise and errors; the suspension has a separate seed.
        WHEEL_STREAM, TILT_STREAM: numbers of their random number streams.
    """

    route: Route
    suspension: Suspension
    wheels: WheelErrors
    tilt: TiltErrors
    seed: int
    WHEEL_STREAM: ClassVar[int]
    TILT_STREAM: ClassVar[int]

    def pose_at(self, time: float) -> SE2:
        """Return ``T_map_base`` at a time [s], its place and heading on the floor: the truth."""
        return self.route.pose_at(time)

    def tilt_at(self, time: float) -> tuple[float, float]:
        """Return the true fixed-axis roll and pitch of ``base_link`` at a time [s] in [rad]."""
        _, roll, pitch = self.suspension.motion_at(time).tolist()
        return roll, pitch

    def odometry(self, seconds: float, period: float = 0.02) -> list[WheelReading]:
        """Return the wheel odometry of the first seconds, a reading each period [s]."""
        return simulate_wheel_readings(self.pose_at, seconds, period, self.wheels, self.rng(self.WHEEL_STREAM))

    def tilt_readings(self, seconds: float, period: float = 0.02) -> list[TiltReading]:
        """Return the inertial unit's tilt in the first seconds, a reading each period [s]."""
        times = np.arange(0.0, seconds, period).tolist()
        return simulate_tilt(self.tilt_at, times, self.tilt, self.rng(self.TILT_STREAM))

    def rng(self, *purpose: int) -> np.random.Generator:
        """Return the random numbers of a stream."""
        return np.random.default_rng((self.seed, *purpose))


_STEP = 0.005  # distance between the points of a route at which the speed is planned [m]
_MIN_SEPARATION = 1e-3  # a place that is nearer to a waypoint is left out [steps]


@dataclass(frozen=True)
class Waypoint:
    """A point of a route.

    Attributes:
        x: place in the map frame [m].
        y: place in the map frame [m].
        speed: greatest speed on the way to the next point [m/s].
        pause: stop time at the point; 0 drives through [s].
    """

    x: float
    y: float
    speed: float
    pause: float = 0.0


@dataclass(frozen=True)
class DriveLimits:
    """Greatest acceleration along the drive and across a bend [m/s^2]."""

    acceleration: float = 0.4
    lateral_acceleration: float = 0.3


class RobotDrive:
    """A drive along a route, which the robot always faces; ``duration`` [s] includes the pauses."""

    def __init__(self, route: Sequence[Waypoint], limits: DriveLimits | None = None) -> None:
        """Plan a drive along two or more waypoints within limits, by default a small robot's.

        Raises:
            SceneError: a route that is too short, not finite, has a repeated point or no speed.
        """
        points = np.array([(waypoint.x, waypoint.y) for waypoint in route])
        if not np.isfinite(points).all():
            raise SceneError('a route needs finite places, and one of its points has none')
        if len(route) < 2 or (np.hypot(*np.diff(points, axis=0).T) == 0.0).any():
            raise SceneError('a route needs two points at least, and no point twice in a row')
        if min(waypoint.speed for waypoint in route[:-1]) <= 0.0:
            raise SceneError('a route needs a speed above zero on every leg')
        knots = np.concatenate([[0.0], np.cumsum(np.hypot(*np.diff(points, axis=0).T))])
        self._spline = CubicSpline(knots, points)
        parameters = _plan_parameters(knots)
        stops = np.searchsorted(parameters, knots)
        times, rates = self._compute_timing(parameters, stops, route, limits or DriveLimits())
        # The curve of given places and rates is exact where the acceleration is constant.
        self._parameter_at = CubicHermiteSpline(*_insert_pauses(times, parameters, rates, stops, route))
        self.duration = float(self._parameter_at.x[-1])

    def pose_at(self, time: float) -> SE2:
        """Return ``T_map_base`` at a time since the start [s]; outside the drive the robot is stationary."""
        parameter = float(self._parameter_at(min(max(time, 0.0), self.duration)))
        x, y = self._spline(parameter)
        ahead_x, ahead_y = self._spline(parameter, 1)
        return SE2(float(x), float(y), math.atan2(ahead_y, ahead_x))

    def poses_during(self, middle: float, exposure: float, count: int) -> list[SE2]:
        """Return ``T_map_base`` at even instants of an exposure [s]; an odd number of them holds its middle."""
        instants = (np.arange(count) + 0.5) / count - 0.5
        return [self.pose_at(middle + exposure * float(instant)) for instant in instants]

    def _compute_timing(
        self, parameters: NDArray[np.float64], stops: NDArray[np.int64], route: Sequence[Waypoint], limits: DriveLimits
    ) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
        """Return when the robot is at each place, pauses left out [s], and the places' rate [1/s]."""
        velocity, second = self._spline(parameters, 1), self._spline(parameters, 2)
        norm = np.hypot(*velocity.T)
        curvature = np.abs(velocity[:, 0] * second[:, 1] - velocity[:, 1] * second[:, 0]) / norm**3
        legs = np.clip(np.searchsorted(stops, np.arange(len(parameters)), side='right') - 1, 0, len(route) - 2)
        speeds = np.array([waypoint.speed for waypoint in route])[legs]
        speeds = np.minimum(speeds, np.sqrt(limits.lateral_acceleration / np.maximum(curvature, 1e-9)))
        stationary = [0, len(route) - 1, *(i for i, waypoint in enumerate(route) if waypoint.pause > 0.0)]
        speeds[stops[stationary]] = 0.0
        lengths = np.diff(parameters) * 0.5 * (norm[1:] + norm[:-1])
        speeds = _limit_acceleration(speeds, lengths, limits.acceleration)
        times = np.concatenate([[0.0], np.cumsum(2.0 * lengths / (speeds[1:] + speeds[:-1]))])
        return times, speeds / norm


def _plan_parameters(knots: NDArray[np.float64]) -> NDArray[np.float64]:
    """Return the knots and even steps between them, rising, shape (n,) [m]."""
    steps = np.arange(0.0, knots[-1], _STEP)
    after = np.searchsorted(knots, steps)
    gaps = np.minimum(np.abs(knots[after] - steps), np.abs(knots[after - 1] - steps))
    # A step that rounding alone parts from a knot would be reached at the same time.
    return np.sort(np.concatenate([knots, steps[gaps > _MIN_SEPARATION * _STEP]]))


def _limit_acceleration(
    speeds: NDArray[np.float64], lengths: NDArray[np.float64], acceleration: float
) -> NDArray[np.float64]:
    """Return speeds lowered until no step of the route changes them faster than allowed."""
    squares = speeds**2
    for i, length in enumerate(lengths):
        squares[i + 1] = min(squares[i + 1], squares[i] + 2.0 * acceleration * length)
    for i in range(len(lengths) - 1, -1, -1):
        squares[i] = min(squares[i], squares[i + 1] + 2.0 * acceleration * lengths[i])
    return np.sqrt(squares)


def _insert_pauses(
    times: NDArray[np.float64],
    parameters: NDArray[np.float64],
    rates: NDArray[np.float64],
    stops: NDArray[np.int64],
    route: Sequence[Waypoint],
) -> tuple[NDArray[np.float64], NDArray[np.float64], NDArray[np.float64]]:
    """Return times, places and rates with each pause put in as a second time at the same place."""
    for stop, waypoint in reversed(list(zip(stops, route, strict=True))):
        if waypoint.pause > 0.0:
            later = times[stop:] + waypoint.pause
            times = np.concatenate([times[: stop + 1], later])
            parameters, rates = (np.concatenate([x[: stop + 1], x[stop:]]) for x in (parameters, rates))
    return times, parameters, rates
