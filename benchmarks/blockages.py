"""Corridors that somebody blocks for a while: whether the map lets the planner through again, and what it keeps.

The robot drives up to somebody who stands in its corridor, and waits; who stood there leaves. Many rays return nothing
(+inf). Somebody either walks in while the robot looks, or stands there from the first sight. The way is free again when
the planner finds a route past the place; kept cells are occupied ones where nothing is. Without a route the robot
backs up and clears the map around it when its recovery behaviors come to that; it does not turn to look around.
"""

import math
from collections.abc import Callable
from contextlib import suppress
from dataclasses import dataclass

import numpy as np
from _figures import count, error, rate
from _harness import Option, Run, progress, run_benchmark
from numpy.typing import NDArray

from reward_planner.core.depth.trinocular_depth import points_from_depth_image
from reward_planner.core.navigator import Navigator, NavigatorSettings, SensorFrame
from reward_planner.core.occupancy_map import OCCUPIED, UNKNOWN, GridFrame, OccupancyMap
from reward_planner.core.reward_planner_error import RewardPlannerError
from reward_planner.core.route.route import NoRoute
from reward_planner.core.settings import DrivingSettings
from scene_simulator.mission.pedestrians import Walker
from scene_simulator.room.box_room import BoxRoom, Solids, cast_rays
from shirube_core.geometry import SE2, CameraMount, PinholeCamera, matrix_from_rpy

PIXELS = ((80, 60), (120, 90), (320, 240), (640, 480))
VIEWS, WIDTHS = (30, 60, 90), (1.0, 1.5, 2.0, 2.5)
KINDS = ('person', 'legs', 'child', 'wheelchair', 'trolley')
LENGTH, SENSOR_RANGE, RESOLUTION = 14.0, 6.0, 0.05  # length of the corridor, range of the sensor, side of a cell [m]
PERIOD, SPEED, STAND, PATIENCE = 0.2, 0.5, 6.0, 40.0
"""Time between frames [s], speed of the robot [m/s], time that somebody stands, and after it [s]."""
GOAL = SE2(9.0, 0.0, 0.0)
DRIVING = DrivingSettings()
RECOVERY = 1.0 + 2.0 * math.tau / DRIVING.max_angular_velocity + DRIVING.recovery_wait
"""Time without a route until the robot has looked around and waited [s]."""


@dataclass(frozen=True)
class Blockage:
    """A corridor, its camera, somebody at a place, who came there or always was, and where the robot stops, x [m]."""

    width: float
    view: int
    camera: PinholeCamera
    mount: CameraMount
    kind: str
    place: SE2
    stop: float
    enters: bool

    @property
    def room(self) -> BoxRoom:
        """The corridor."""
        return BoxRoom((-2.0, -0.5 * self.width, 0.0, LENGTH, 0.5 * self.width, 2.6))

    @property
    def leaves(self) -> float:
        """Time at which somebody leaves [s]."""
        return self.stop / SPEED + STAND

    def people_at(self, time: float) -> Solids:
        """Return who is there at a time [s]: he comes at 1 m/s, and leaves at 1 m/s the way he came."""
        away = max(time - self.leaves, self.stop / SPEED - time if self.enters else 0.0, 0.0)
        return Walker(self.kind, self.place @ SE2(-away, 0.0, 0.0), 0.0).solids_at(0.0)


def blockage(seed: int) -> Blockage:
    """Return a blockage of a seed."""
    rng = np.random.default_rng((23, seed))
    columns, rows = PIXELS[seed % 4]
    view, enters = VIEWS[seed // 4 % 3], bool(seed // 12 % 2)
    focal_length = 0.5 * rows / math.tan(math.radians(0.5 * view))
    camera = PinholeCamera(columns, rows, focal_length, focal_length, 0.5 * (columns - 1), 0.5 * (rows - 1))
    down = float(rng.uniform(0.0, 0.2))
    mount = CameraMount((0.1, 0.0, float(rng.uniform(0.25, 0.6))), (-0.5 * math.pi - down, 0.0, -0.5 * math.pi))
    width = float(rng.choice(WIDTHS))
    place = SE2(float(rng.uniform(3.0, 5.0)), float(rng.uniform(-0.1, 0.1)), math.pi)
    kind, stop = str(rng.choice(KINDS)), place.x - 0.45 - float(rng.uniform(0.2, 1.0))
    return Blockage(width, view, camera, mount, kind, place, stop, enters)


def depth_at(scene: Blockage, time: float, pose: SE2, rng: np.random.Generator) -> NDArray[np.float32]:
    """Return a depth image with noise and pixels without depth (NaN), +inf where nothing is within range."""
    camera = scene.camera
    v, u = np.mgrid[0.0 : camera.height, 0.0 : camera.width]
    rays = np.stack([(u - camera.cx) / camera.fx, (v - camera.cy) / camera.fy, np.ones_like(u)], axis=2)
    turn = matrix_from_rpy((0.0, 0.0, pose.yaw))
    origin = turn @ scene.mount.xyz + (pose.x, pose.y, 0.0)
    directions = rays.reshape(-1, 3) @ (turn @ scene.mount.rotation).T
    depth = cast_rays(scene.room, scene.people_at(time), origin, directions)
    depth += 0.003 * depth**2 * rng.standard_normal(len(depth))
    depth[depth * np.hypot(1.0, np.hypot(*rays.reshape(-1, 3)[:, :2].T)) > SENSOR_RANGE] = np.inf
    depth[rng.random(len(depth)) < 0.02] = np.nan
    return depth.reshape(camera.height, camera.width).astype(np.float32)


def known_walls(scene: Blockage) -> OccupancyMap:
    """Return the walls as a map; the corridor is unknown."""
    frame = GridFrame(-3.0, -3.0, RESOLUTION, round((LENGTH + 4.0) / RESOLUTION), round(6.0 / RESOLUTION))
    solid = scene.room.solid_cells((-3.0, -3.0), RESOLUTION, frame.shape, (0.1, 1.2))
    return OccupancyMap(frame, np.where(solid, OCCUPIED, UNKNOWN).astype(np.int8))


GROUPS: dict[str, Callable[[Blockage], str]] = {
    'Image': lambda scene: f'{scene.camera.width} x {scene.camera.height}',
    'Vertical view': lambda scene: f'{scene.view}°',
    'Width': lambda scene: f'{scene.width} m',
    'Arrival': lambda scene: 'walks in' if scene.enters else 'stands there at first sight',
    'All': lambda _: 'all',
}


@dataclass(frozen=True)
class Outcome:
    """Time from the leave until a route was found [s], inf for none; occupied cells that were kept."""

    time: float
    kept: int
    blocked: bool


def run_blockage(scene: Blockage, seed: int) -> Outcome:
    """Drive up, wait, and plan after each frame until the map is free or patience ends."""
    rng = np.random.default_rng((24, seed))
    navigator, walls = Navigator(scene.mount, NavigatorSettings()), known_walls(scene)
    navigator.set_static_map(walls)
    x, y = walls.frame.centre_of(np.argwhere(np.ones(walls.frame.shape, dtype=np.bool_))).T
    inside = (np.abs(y) < 0.5 * scene.width - 0.15) & (x > 0.0) & (x < GOAL.x)
    was_blocked, freed, kept, cleared = False, math.inf, 0, False
    for step in range(math.ceil((scene.leaves + PATIENCE) / PERIOD)):
        time = step * PERIOD
        recovering = time - scene.stop / SPEED - RECOVERY if math.isinf(freed) else -1.0
        backed = min(max(0.1 * recovering, 0.0), DRIVING.recovery_distance)
        navigator.add_pose(time, pose := SE2(min(SPEED * time, scene.stop) - backed, 0.0, 0.0))
        if not cleared and backed == DRIVING.recovery_distance:
            navigator.clear_around(pose, DRIVING.recovery_radius)
            cleared = True
        points = points_from_depth_image(depth_at(scene, time, pose, rng), scene.camera)
        navigator.add_frame(time, time, SensorFrame(points, scene.camera.fx))
        with suppress(RewardPlannerError):  # a covered camera: the node reports it and stops
            navigator.process_frames(time)
        if abs(time - scene.leaves + PERIOD) < 0.5 * PERIOD:
            was_blocked = isinstance(navigator.route_between(pose, GOAL, time), NoRoute)
        if time < scene.leaves + 1.0 or step % 3:
            continue
        kept = int((navigator.mapper.map.occupancy_in(walls.frame).reshape(-1)[inside] == OCCUPIED).sum())
        if math.isinf(freed) and not isinstance(navigator.route_between(pose, GOAL, time), NoRoute):
            freed = time - scene.leaves
        if freed < math.inf and (kept == 0 or time > scene.leaves + 10.0):
            break
    return Outcome(freed, kept, was_blocked)


def main(run: Run, cases: int) -> None:
    """Run all blockages."""
    seeds = progress(range(run.seed, run.seed + cases))
    found = [(blockage(seed), run_blockage(blockage(seed), seed)) for seed in seeds]
    heads = 'blocked before | way free again | time s: median / 95 % / max | kept cells'
    for title, key in GROUPS.items():
        table = run.table(title, f'{title.lower()} | {heads}')
        for name in dict.fromkeys(key(scene) for scene, _ in found):
            group = [outcome for scene, outcome in found if key(scene) == name]
            times = [outcome.time for outcome in group if outcome.time < math.inf]
            blocked, kept = (sum(each) for each in zip(*((o.blocked, o.kept) for o in group), strict=True))
            counts = rate(blocked, len(group), ''), rate(len(times), len(group))
            table.add(name, *counts, error(times, '.1f'), count(kept, better='lower'))


if __name__ == '__main__':
    run_benchmark(main, cases=Option(200, 12, 'blockages'))
