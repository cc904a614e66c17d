"""Seeded encounters of a robot with people, and, from geometry alone, which contacts a stop would have prevented."""

import math
from dataclasses import dataclass
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from reward_planner.core.safety.range_frame import thinning_stride
from scene_simulator.mission.pedestrians import Walker
from scene_simulator.room.box_room import Box, BoxRoom, Solids, cast_rays
from shirube_core.geometry import SE2, CameraMount, matrix_from_rpy

RADIUS, HEIGHT, LATENCY = 0.2, 0.6, 0.05  # the robot: radius and height [m], latency [s]
SITUATIONS = ('head-on', 'crossing', 'corner', 'overtaking', 'following', 'standing')
SIZE: Box = (-6.0, -7.0, 0.0, 9.0, 7.0, 2.6)
RATES = (5.0, 10.0, 20.0, 30.0)
PIXELS = ((80, 60), (120, 90), (160, 120), (320, 240), (640, 480))
SIGHT = 4.0  # range of the sensors and of the view [m]
_STEP = 0.01


@dataclass(frozen=True)
class Sensor:
    """A depth camera, or a laser scanner (no rows).

    Attributes:
        columns, rows: size of the image; beams of a scan and 0.
        view: horizontal field of view [rad].
        rate: measurements a second.
        noise: standard deviation of a range of 1 m, growing with its square [m].
        dropout: fraction of pixels without range, and of measurements that are lost.
        mount: pose of its frame, x ahead, in the base frame.
    """

    columns: int
    rows: int
    view: float
    rate: float
    noise: float
    dropout: float
    mount: CameraMount

    @cached_property
    def directions(self) -> NDArray[np.float64]:
        """Rays in the sensor frame, x ahead, shape (n, 3), of length 1 along the axis; of a scan of length 1.

        Of large images only those that the monitor uses, which thins them in the same way.
        """
        if not self.rows:
            angles = np.linspace(-0.5 * self.view, 0.5 * self.view, self.columns)
            return np.column_stack([np.cos(angles), np.sin(angles), 0.0 * angles])
        slope = 2.0 * math.tan(0.5 * self.view) / self.columns
        y = (0.5 * (self.columns - 1) - np.arange(self.columns)) * slope
        z = (0.5 * (self.rows - 1) - np.arange(self.rows)) * slope
        grid = np.stack(np.broadcast_arrays(1.0, y[None], z[:, None]), axis=2)
        return np.ascontiguousarray(grid.reshape(-1, 3)[:: thinning_stride(self.columns * self.rows)])

    @cached_property
    def rotation(self) -> NDArray[np.float64]:
        """R_base_sensor, shape (3, 3)."""
        return matrix_from_rpy(self.mount.rpy)

    def ranges(self, room: BoxRoom, solids: Solids, pose: SE2, rng: np.random.Generator) -> NDArray[np.float64]:
        """Return the ranges of the rays in their lengths, with noise, wrong single pixels, NaN where missing."""
        turn = matrix_from_rpy((0.0, 0.0, pose.yaw))
        origin = turn @ self.mount.xyz + (pose.x, pose.y, 0.0)
        found = cast_rays(room, solids, origin, self.directions @ (turn @ self.rotation).T)
        found += self.noise * found**2 * rng.standard_normal(len(found), dtype=np.float32)
        wrong = rng.random(len(found), dtype=np.float32) < 0.0005
        found[wrong] = rng.uniform(0.3, SIGHT, int(wrong.sum()))
        found[rng.random(len(found), dtype=np.float32) < self.dropout] = np.nan
        return found

    def sees(self, room: BoxRoom, walkers: Solids, pose: SE2) -> bool:
        """Return whether the middle of a body is in the field of view and nothing hides it: geometry without noise."""
        turn = matrix_from_rpy((0.0, 0.0, pose.yaw)) @ self.rotation
        origin = matrix_from_rpy((0.0, 0.0, pose.yaw)) @ self.mount.xyz + (pose.x, pose.y, 0.0)
        targets = [(*np.mean([c[:2], c[3:5]], axis=0), z) for c in walkers.cylinders for z in _heights(c[2], c[5])]
        targets += [(b[0], b[1], z) for b in walkers.boxes for z in _heights(b[5], b[6])]
        rays = np.array(targets) - origin
        x, y, z = (rays @ turn).T
        if self.rows:
            limit = math.tan(0.5 * self.view)
            inside = (x > 0.0) & (abs(y) < limit * x) & (abs(z) < limit * self.rows / self.columns * x)
        else:
            # The plane of the scan cuts the body, rather than touch its edge.
            heights = [sorted((c[2], c[5])) for c in walkers.cylinders] + [b[5:7] for b in walkers.boxes]
            cut = [low + 0.02 < origin[2] < high - 0.02 for low, high in heights for _ in _heights(low, high)]
            inside = (abs(np.arctan2(y, x)) < 0.5 * self.view) & (abs(z) < 0.1) & np.array(cut)
        inside &= np.hypot(x, y) < SIGHT
        return bool(inside.any()) and bool((cast_rays(room, Solids(), origin, rays[inside]) > 1.0).any())


def _heights(low: float, high: float) -> NDArray[np.float64]:
    return np.arange(min(low, high), max(low, high) + 0.05, 0.1)


@dataclass(frozen=True)
class Encounter:
    """A commanded drive, somebody on the way, a room and a sensor."""

    situation: str
    walker: Walker
    room: BoxRoom
    sensor: Sensor
    command: tuple[float, float]
    deceleration: float
    end: float


def encounter(seed: int) -> Encounter:
    """Return an encounter of a seed."""
    rng = np.random.default_rng((23, seed))
    situation = SITUATIONS[seed % len(SITUATIONS)]
    forward, turn = rng.uniform(0.3, 0.8), float(rng.choice([0.0, 0.0, rng.uniform(-0.3, 0.3)]))
    speed, meeting = rng.uniform(0.3, 1.6), rng.uniform(2.0, 4.0)
    kinds = ('person', 'legs', 'child', 'group', 'wheelchair', 'trolley')
    kind, boxes = str(rng.choice(kinds)), tuple[Box, ...]()
    match situation:
        case 'head-on':
            heading = math.pi + rng.normal(0.0, 0.15)
        case 'crossing':
            heading = rng.choice([-1.0, 1.0]) * rng.uniform(0.9, 2.3)
        case 'corner':
            turn, heading = 0.0, -0.5 * math.pi
        case 'overtaking':
            heading, speed = rng.normal(0.0, 0.3), rng.uniform(forward + 0.3, 1.6)
        case 'following':
            heading, forward, speed = rng.normal(0.0, 0.2), rng.uniform(0.5, 0.8), 0.3
        case _:
            heading, speed, kind = (rng.uniform(-3.1, 3.1), 0.0, str(rng.choice(['lying body', 'standing body'])))
    deceleration = float(rng.choice([0.5, 1.0]))
    driven = meeting - LATENCY - 0.5 * forward / deceleration
    place = SE2.exp(forward * driven, 0.0, turn * driven)
    if situation == 'corner':
        x = place.x + 0.4
        boxes = ((x - rng.uniform(0.8, 1.5), rng.uniform(0.35, 0.6), 0.0, x - rng.uniform(0.3, 0.5), 4.0, 2.0),)
        place = SE2(x - 0.1, 0.0, 0.0)
    heading += place.yaw
    aside = rng.normal(0.0, 0.2)
    meet = SE2(place.x - aside * math.sin(heading), place.y + aside * math.cos(heading), heading)
    walker = Walker(kind, meet @ SE2(-speed * meeting, 0.0, 0.0), speed)
    return Encounter(
        situation, walker, BoxRoom(SIZE, boxes), random_sensor(rng), (forward, turn), deceleration, meeting + 3.0
    )  # fmt: skip


def random_sensor(rng: np.random.Generator) -> Sensor:
    """Return a sensor of chance."""
    rate, noise, dropout = float(rng.choice(RATES)), rng.uniform(0.001, 0.008), rng.uniform(0.0, 0.03)
    if rng.random() < 0.2:
        mount = CameraMount((0.1, 0.0, 0.2), (0.0, 0.0, 0.0))
        return Sensor(360, 0, rng.uniform(2.0, 4.7), rate, noise, dropout, mount)
    columns, rows = PIXELS[int(rng.choice(5, p=[0.4, 0.2, 0.25, 0.11, 0.04]))]
    mount = CameraMount((0.1, 0.0, rng.uniform(0.25, 0.5)), (0.0, rng.uniform(0.0, 0.2), 0.0))
    return Sensor(columns, rows, rng.uniform(1.0, 1.6), rate, noise, dropout, mount)


@dataclass(frozen=True)
class View:
    """What geometry says about a contact.

    Attributes:
        avoidable: a stop one sensor period and the latency after the first sight would have prevented it.
        first_seen: whether somebody was in view at any time.
        seen: somebody was in view for one sensor period and the stopping time without a break before it.
    """

    avoidable: bool
    first_seen: bool
    seen: bool


def judge_contact(scene: Encounter, times: list[float], poses: list[SE2], speeds: list[float], period: float) -> View:
    """Return what geometry says about a contact at the last time, without any part of the monitor.

    Args:
        scene: the encounter.
        times: times until the contact [s].
        poses: true poses of the robot.
        speeds: its true speeds [m/s].
        period: longest time between two measurements that arrived [s].
    """
    # Every 50 ms: shorter looks are less than a sensor period.
    kept = range((len(times) - 1) % 5, len(times), 5)
    times, poses, speeds = [times[k] for k in kept], [poses[k] for k in kept], [speeds[k] for k in kept]
    in_view = [scene.sensor.sees(scene.room, scene.walker.solids_at(t), p) for t, p in zip(times, poses, strict=True)]
    if not any(in_view):
        return View(avoidable=False, first_seen=False, seen=False)
    first, step = in_view.index(True), times[1] - times[0]
    avoidable = _stop_prevents(scene, times[first], poses[first], speeds[first], period)
    longest = run = 0
    needed = 0.0
    for k, sees in enumerate(in_view):
        run = run + 1 if sees else 0
        if run > longest:
            longest, needed = run, period + LATENCY + speeds[k - run + 1] / scene.deceleration
    return View(avoidable, True, longest * step >= needed)


def _stop_prevents(scene: Encounter, time: float, pose: SE2, speed: float, period: float) -> bool:
    """Return whether the robot is not touched if it brakes one period and the latency after a time [s]."""
    brake = time + period + LATENCY
    rate, gap = scene.command[1] / scene.command[0], math.inf
    while True:
        if time >= brake:
            speed = max(speed - scene.deceleration * _STEP, 0.0)
        pose = pose @ SE2.exp(speed * _STEP, 0.0, rate * speed * _STEP)
        time += _STEP
        before, gap = gap, scene.walker.solids_at(time).clearance(pose.x, pose.y, RADIUS, HEIGHT)
        if gap <= 0.0:
            return False
        if speed == 0.0 and (gap > before + 1e-4 or scene.walker.speed == 0.0) and gap > 1.0:
            return True
        if time > scene.end + 20.0:
            return True
