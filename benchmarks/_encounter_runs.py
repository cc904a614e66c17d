"""One encounter with the pure collision monitor, or without it, in simulated time."""

from dataclasses import dataclass

import numpy as np
from _encounter_scenes import HEIGHT, LATENCY, RADIUS, SIGHT, Encounter, Sensor, View, judge_contact
from numpy.typing import NDArray

from reward_planner.core.safety.collision_monitor import CollisionMonitor
from reward_planner.core.safety.range_frame import RangeFrame, range_frame
from reward_planner.core.safety.safety_settings import CollisionMonitorSettings, SourceSettings
from shirube_core.geometry import SE2

STEP = 0.01
_CONTROL_STEPS = 5
LOOK = 1.0  # time before the command, in which the sensor sees the room [s]


class Base:
    """A base that follows velocities after its latency, within its accelerations."""

    def __init__(self, pose: SE2, deceleration: float, latency: float = LATENCY) -> None:
        self.pose, self.forward, self.turn_rate = pose, 0.0, 0.0
        self._deceleration, self._latency = deceleration, latency
        self._given: list[tuple[float, float, float]] = []

    def give(self, time: float, forward: float, turn_rate: float) -> None:
        """Give a velocity [m/s, rad/s] at a time [s]."""
        self._given.append((time + self._latency, forward, turn_rate))

    def step(self, time: float, dt: float = STEP) -> None:
        """Move up to a time [s]."""
        while len(self._given) > 1 and self._given[1][0] <= time:
            self._given.pop(0)
        if self._given and self._given[0][0] <= time:
            _, forward, turn_rate = self._given[0]
            self.forward += float(np.clip(forward - self.forward, -self._deceleration * dt, self._deceleration * dt))
            self.turn_rate += float(np.clip(turn_rate - self.turn_rate, -3.0 * dt, 3.0 * dt))
        self.pose = self.pose @ SE2.exp(self.forward * dt, 0.0, self.turn_rate * dt)


def settings_for(deceleration: float) -> CollisionMonitorSettings:
    """Return the settings of the robot; all others are the defaults."""
    return CollisionMonitorSettings(robot_radius=RADIUS, deceleration=deceleration, latency=LATENCY)


def source_for(sensor: Sensor) -> SourceSettings:
    """Return the settings of a sensor; all others are the defaults."""
    return SourceSettings(type='points' if sensor.rows else 'scan', range_max=SIGHT)


def frame_of(sensor: Sensor, ranges: NDArray[np.float64]) -> RangeFrame:
    """Return the frame of ranges in the rays' lengths."""
    points = (sensor.directions * ranges[:, None]).astype(np.float32)
    hit = np.ones(len(points), dtype=np.bool_)
    return range_frame(points, hit, sensor.rotation, np.array(sensor.mount.xyz))


@dataclass(frozen=True)
class Outcome:
    """Contact or none, the robot's speed then [m/s], and what geometry says."""

    contact: bool
    speed: float = 0.0
    view: View | None = None


def run_encounter(scene: Encounter, seed: int, *, monitored: bool = True) -> Outcome:
    """Drive until contact or the end of the encounter."""
    rng = np.random.default_rng((24, seed))
    monitor = CollisionMonitor(settings_for(scene.deceleration), {'sensor': source_for(scene.sensor)})
    base = Base(SE2(0.0, 0.0, 0.0), scene.deceleration)
    times, poses, speeds = [], [], []
    period = 1.0 / scene.sensor.rate
    last_frame = -LOOK
    next_frame = last_frame + rng.uniform(0.0, period)
    for step in range(-round(LOOK / STEP), int(scene.end / STEP)):
        time = STEP * step
        now = 100.0 + time
        decide = step % _CONTROL_STEPS == 0
        command = scene.command if step >= 0 else (0.0, 0.0)
        if decide:
            monitor.add_command(now, *command)
        if time >= next_frame:
            next_frame += 1.0 / scene.sensor.rate
            if rng.random() >= scene.sensor.dropout:
                ranges = scene.sensor.ranges(scene.room, scene.walker.solids_at(time), base.pose, rng)
                monitor.add_frame('sensor', now, now, frame_of(scene.sensor, ranges))
                period = max(period, time - last_frame)
                last_frame, decide = time, True
        if decide:
            given = command
            if monitored:
                decision = monitor.decide(now)
                given = decision.forward, decision.turn_rate
            base.give(time, *given)
        base.step(time)
        times.append(time + STEP)
        poses.append(base.pose)
        speeds.append(base.forward)
        gap = scene.walker.solids_at(times[-1]).clearance(base.pose.x, base.pose.y, RADIUS, HEIGHT)
        if gap <= 0.0 and step < 1:
            return Outcome(False)  # they met before the encounter began
        if gap <= 0.0:
            view = judge_contact(scene, times, poses, speeds, period)
            return Outcome(True, base.forward, view)
    return Outcome(False)
