"""The mission's rooms with people who walk: the cores of planner and collision monitor alone, without any node.

The pose is exact, the depth images are those of the mission, and no lamp sends commands.
"""

import math
from collections.abc import Callable
from contextlib import suppress
from dataclasses import dataclass, field, replace

import numpy as np
from _encounter_runs import Base
from _figures import count, error, rate
from _harness import Option, Run, progress, run_benchmark
from numpy.typing import NDArray

from motor_bridge.core.diff_drive_kinematics import DriveSettings
from reward_planner.core.depth.trinocular_depth import points_from_depth_image
from reward_planner.core.driving.drive_state import DriveState
from reward_planner.core.navigator import Navigator, NavigatorSettings, SensorFrame
from reward_planner.core.reward_planner_error import RewardPlannerError
from reward_planner.core.safety.collision_monitor import CollisionMonitor
from reward_planner.core.safety.range_frame import range_frame
from reward_planner.core.safety.safety_settings import CollisionMonitorSettings, SourceSettings
from reward_planner.core.settings import DrivingSettings, VoxelSettings
from scene_simulator.mission.layout import NOMINAL, ROBOT_HEIGHT, ROBOT_RADIUS
from scene_simulator.mission.pedestrians import RADIUS, mission_pedestrians
from scene_simulator.mission.sensors import DEPTH_CAMERA, DEPTH_MOUNT, MissionSensors
from scene_simulator.room.box_room import disc_clearance

STEP, CONTROL_PERIOD, FRAME_PERIOD, FRAME_LATENCY = 0.01, 0.05, 0.2, 0.08
DEPTH_RANGE, GOAL_TIME = 3.5, 180.0
"""Range of the depth camera [m], time for each goal [s]."""
DRIVING = DrivingSettings(
    0.4, 1.0, max_angular_acceleration=2.0, slow_distance=0.12, goal_tolerance=0.01, goal_yaw_tolerance=0.04
)


@dataclass
class Outcome:
    """What came of a mission.

    Attributes:
        times: time of each goal that was reached [s].
        clearance: least distance to people [m].
        contact_speed: greatest speed of the robot while it touches somebody [m/s], NaN if it never does.
        collisions: control cycles in which it touches furniture.
    """

    times: list[float] = field(default_factory=list)
    clearance: float = math.inf
    contact_speed: float = math.nan
    collisions: int = 0


class Drive:
    """A robot with planner and collision monitor in the room of a seed."""

    def __init__(self, seed: int, people: int, speed: float) -> None:
        self.sensors = MissionSensors(seed, {})
        self.people = mission_pedestrians(seed, people, self.sensors.room, self.sensors.layout)
        limits, self.outcome, self.time = DriveSettings(), Outcome(), 0.0
        self.base = Base(self.sensors.layout.start, limits.max_linear_acceleration)
        driving = replace(DRIVING, max_linear_velocity=speed)
        voxels = VoxelSettings(height_max=ROBOT_HEIGHT, range_max=DEPTH_RANGE)
        self.navigator = Navigator(DEPTH_MOUNT, NavigatorSettings(voxels=voxels, driving=driving))
        braking = limits.max_linear_acceleration, limits.max_angular_acceleration
        settings = CollisionMonitorSettings((), ROBOT_RADIUS, *braking)
        source = SourceSettings(type='depth', range_max=DEPTH_RANGE, height_max=ROBOT_HEIGHT)
        self.monitor = CollisionMonitor(settings, {'front': source})
        self._frames: list[tuple[float, NDArray[np.float32]]] = []
        self._index = 0

    def run(self) -> Outcome:
        """Drive from goal to goal."""
        self._until(lambda _: False, 1.0)
        for goal in self.sensors.layout.goals:
            self.navigator.set_goal(goal)
            began = self.time
            if not self._until(lambda state: state is DriveState.GOAL_REACHED, GOAL_TIME):
                break
            self.outcome.times.append(self.time - began)
        return self.outcome

    def _until(self, is_done: Callable[[DriveState], bool], seconds: float) -> bool:
        end, steps = self.time + seconds, round(CONTROL_PERIOD / STEP)
        while self.time < end:
            self._sense()
            if is_done(self._control()):
                return True
            for _ in range(steps):
                self.time += STEP
                self.base.step(self.time)
                for person in self.people:
                    person.advance(STEP, self.base.pose)
            self._judge()
        return False

    def _sense(self) -> None:
        pose, now = self.base.pose, self.time
        self.navigator.add_pose(now, pose)
        self.monitor.add_odometry(now, pose)
        if now >= self._index * FRAME_PERIOD - 1e-6:
            places = [person.place for person in self.people]
            self._frames.append((now, self.sensors.depth_picture(self._index, now, lambda _: pose, places)))
            self._index += 1
        if self._frames and now >= self._frames[0][0] + FRAME_LATENCY - 1e-6:
            stamp, depth = self._frames.pop(0)
            points = points_from_depth_image(depth, DEPTH_CAMERA)
            self.navigator.add_frame(stamp, now, SensorFrame(points, DEPTH_CAMERA.fx))
            with suppress(RewardPlannerError):  # somebody fills the view: without a map, the robot stops
                self.navigator.process_frames(now)
            hit = np.ones(len(points), dtype=np.bool_)
            frame = range_frame(points, hit, DEPTH_MOUNT.rotation, np.array(DEPTH_MOUNT.xyz))
            self.monitor.add_frame('front', stamp, now, frame)

    def _control(self) -> DriveState:
        drive = self.navigator.controller.step(self.time)
        velocity = drive.velocity
        self.monitor.add_command(self.time, *((velocity.forward, velocity.turn_rate) if velocity else (0.0, 0.0)))
        decision = self.monitor.decide(self.time)
        self.base.give(self.time, decision.forward, decision.turn_rate)
        return drive.state

    def _judge(self) -> None:
        pose, outcome = self.base.pose, self.outcome
        gaps = [math.dist(person.place, (pose.x, pose.y)) - RADIUS - ROBOT_RADIUS for person in self.people]
        outcome.clearance = min([outcome.clearance, *gaps])
        if min(gaps, default=math.inf) < 0.0:
            outcome.contact_speed = max(np.nan_to_num(outcome.contact_speed), abs(self.base.forward))
        room = self.sensors.room.boxes
        outcome.collisions += disc_clearance(room, pose.x, pose.y, ROBOT_RADIUS, ROBOT_HEIGHT) <= 0.0


def main(run: Run, cases: int, people: int, speed: float) -> None:
    """Run all missions."""
    seeds = range(run.seed, run.seed + cases)
    outcomes = [Drive(seed, people, speed).run() for seed in progress(seeds, 'missions')]
    table = run.table(
        'Missions among people',
        'people | missions | all goals reached | people touched by a moving robot | furniture touched',
        'time of a goal s: median / 95 % / max | distance from people mm: median / 5 % / least',
    )
    touched = sum(outcome.contact_speed > 0.0 for outcome in outcomes)
    table.add(
        *(people, cases, rate(sum(len(outcome.times) == len(NOMINAL.goals) for outcome in outcomes), cases)),
        *(count(touched, better='lower'), count(sum(o.collisions > 0 for o in outcomes), better='lower')),
        error([time for outcome in outcomes for time in outcome.times], '.0f'),
        error([outcome.clearance for outcome in outcomes], '.0f', 1e3, (50, 5, 0), 'higher'),
    )
    failed = [seed for seed, outcome in zip(seeds, outcomes, strict=True) if len(outcome.times) < len(NOMINAL.goals)]
    run.note(f'Goals not reached within {GOAL_TIME:g} s: seeds {failed}')


if __name__ == '__main__':
    run_benchmark(
        main, cases=Option(40, 1, 'missions'), people=Option(2, 1, 'people in the room'), speed=Option(0.4, 0.4, 'm/s')
    )
