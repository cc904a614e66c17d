"""A simulated robot in a grid world: line-of-sight sensing, mapping, the drive controller and collisions."""

import math

import numpy as np
from grid_world import GridWorld
from simulated_robot import MotorLimits, SimulatedRobot

from reward_planner.core.driving.drive_controller import DriveController
from reward_planner.core.driving.drive_state import DriveState
from reward_planner.core.mapping.global_map import GlobalMap, LocalMap
from reward_planner.core.occupancy_map import FREE, OCCUPIED, UNKNOWN, GridFrame, clearance
from reward_planner.core.settings import DrivingSettings, PlannerSettings, RewardSettings
from shirube_core.geometry import SE2

TICK = 0.05
REACH = 3.0
RADIUS = 0.2
BORDER = 20  # unknown cells around the world


class GridDrive:
    """The world has cells of 0.1 m, cell (0, 0) with its corner at (0, 0)."""

    def __init__(self, walls, start, settings=None, mode='optimal', visits='counted', resolution=0.1):
        self.walls, self.resolution = np.asarray(walls, dtype=bool), resolution
        self.global_map = GlobalMap(resolution, 64_000_000)
        self.settings = settings or DrivingSettings()
        planner, reward = PlannerSettings(mode, RADIUS), RewardSettings(visits=visits)
        self.controller = DriveController(self.global_map, planner, reward, self.settings)
        self.robot = SimulatedRobot(start, MotorLimits(0.6, 4.0))
        self.senses_pose = self.senses_map = True
        self.error = SE2(0.0, 0.0, 0.0)  # error of the reported pose
        self.drives, self.poses, self.room = [], [start], []
        self.frame = GridFrame(0.0, 0.0, resolution, *self.walls.shape[::-1])
        self._seen = np.full(self.walls.shape, UNKNOWN, dtype=np.int8)

    @property
    def pose(self):
        return self.robot.pose_at(self.robot.time)

    def sense(self):
        row, column = self.frame.cell_of((self.pose.x, self.pose.y))
        cells, occupied = GridWorld(self.walls).observe((row, column), REACH / self.resolution)
        self._seen[:] = UNKNOWN
        self._seen[cells[:, 0], cells[:, 1]] = np.where(occupied, OCCUPIED, FREE)
        local = LocalMap(self.frame, self._seen, self._seen != UNKNOWN)
        self.global_map.write(local)
        self.controller.update_map(self.robot.time, self.frame)

    def tick(self):
        now = self.robot.time
        if self.senses_pose:
            self.controller.update_pose(now, self.error @ self.pose)
        if self.senses_map and len(self.drives) % 4 == 0:
            self.sense()
        drive = self.controller.step(now)
        velocity = drive.velocity
        forward, turn = (0.0, 0.0) if velocity is None else (velocity.forward, velocity.turn_rate)
        self.robot.drive(forward, turn, now + TICK)
        self.drives.append(drive)
        self.poses.append(self.pose)
        self.room.append(self.gap())
        assert self.room[-1] > 0.0, f'hit a wall at {self.pose}'

    def run(self, seconds, until=(DriveState.GOAL_REACHED,)):
        """Drive until a state is reached; return the last command."""
        for _ in range(round(seconds / TICK)):
            self.tick()
            if self.drives[-1].state in until:
                break
        return self.drives[-1]

    def gap(self):
        """Distance from the robot's edge to the nearest wall [m]."""
        row, column = self.frame.cell_of((self.pose.x, self.pose.y))
        pad = math.ceil(RADIUS / self.resolution) + 1
        part = (slice(max(row - pad, 0), row + pad + 1), slice(max(column - pad, 0), column + pad + 1))
        rows, columns = np.nonzero(self.walls[part])
        low = self.resolution * np.stack([columns + part[1].start, rows + part[0].start], axis=1)
        here = np.array([self.pose.x, self.pose.y])
        nearest = np.clip(here, low, low + self.resolution)
        return float(np.hypot(*(nearest - here).T).min(initial=1.0)) - RADIUS

    def way(self):
        """Length of the path so far [m]."""
        return sum(a.distance_to(b) for a, b in zip(self.poses, self.poses[1:], strict=False))


def goal_at(x, y, yaw=0.0):
    return SE2(x, y, yaw)


def coarse(walls, factor=5):
    """Cells of half a metre as cells of a tenth."""
    return np.repeat(np.repeat(walls, factor, axis=0), factor, axis=1)


def roomy_place(walls, x, y, resolution=0.1):
    """The nearest point with half a metre of clearance."""
    room = clearance(walls, resolution)
    cells = np.argwhere(room > 0.5)
    places = resolution * (cells[:, ::-1] + 0.5)
    return tuple(places[np.hypot(*(places - (x, y)).T).argmin()].tolist())


def hall(rows=60, columns=100):
    """A closed hall of 6 x 10 m."""
    walls = np.zeros((rows, columns), dtype=bool)
    walls[[0, -1]] = walls[:, [0, -1]] = True
    return walls


def hall_drive(goal_x, seconds):
    """A robot that has driven along the hall for some time."""
    drive = GridDrive(hall(), SE2(1.0, 3.0, 0.0))
    drive.controller.set_goal(goal_at(goal_x, 3.0))
    drive.run(seconds)
    return drive


def wall_with_door():
    """The hall with a wall across, and a door at its upper end."""
    walls = hall()
    walls[:45, 50:52] = True
    return walls


def is_stopped(drive):
    velocity = drive.velocity
    return velocity is None or max(abs(velocity.forward), abs(velocity.turn_rate)) < 1e-3
