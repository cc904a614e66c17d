"""Driven under lamps with a 2-D lidar beside: scan-matching SLAM on the first drive, then drives in its map.

Rooms of 7 x 6 m with furniture of chance under the paper's four lamps. Drives of 30 s at 0.4 m/s with odometry that is
off by 2 % and 0.2 degrees a metre; ten scans and images a second. The lidar builds its map on the first drive from the
true start; later drives start within 10 cm and 5 degrees in that map, with the furniture as it was, pushed, or
elsewhere. Lamps that furniture does not hide are found in rendered images of the lit room, and tracked with odometry;
an IMU measures the tilt to 0.1 degrees.
"""

import math
from collections.abc import Iterator
from dataclasses import replace
from itertools import pairwise

import numpy as np
from _figures import error, rate, time
from _harness import Option, Run, cpu_time, progress, run_benchmark, use_one_core
from _lamp_drives import RATE, drive
from _lamp_finders import find_lamps
from _lamp_methods import EXACT
from _lamp_pictures import LIGHTS
from _lamp_room import BEACONS, CAMERA, MOUNT, view_from
from _lidar_matcher import LidarSlam
from _lidar_room import BEAMS, ROBOT_RADIUS, FurnishedRoom, furnished_room, move_furniture

from shirube_core.geometry import SE2
from vlc_beacon.core.pose.beacon_tracker import BeaconTracker
from vlc_beacon.core.pose.pose_fix import BeaconFix

EVERY = round(RATE / 10.0)
GUESS = (0.1, 0.1, math.radians(5.0))
LIGHT = next(light for light in LIGHTS if light.name == 'lit room')
FAR = 0.05  # errors beyond it are counted [m]
TILT = math.radians(0.1)  # standard deviation of the unmeasured roll and pitch [rad]
LIDAR, LAMPS = f'lidar, {BEAMS} beams', 'lamps'

Answer = tuple[SE2 | None, float]  # A pose or none, and the processor time [ms]


def without_obstacles(room: FurnishedRoom, path: list[SE2]) -> FurnishedRoom:
    """Return the room without the pieces that stand in the way of a drive."""
    places = np.array([[pose.x, pose.y] for pose in path])
    free = (item for item in room.furniture if not item.contains(places, ROBOT_RADIUS).any())
    return FurnishedRoom(tuple(free))


def by_lidar(
    slam: LidarSlam, room: FurnishedRoom, path: list[SE2], odometry: list[SE2], rng: np.random.Generator
) -> Iterator[Answer]:
    """Yield the poses of a drive by scan matching."""
    motions = [SE2(0.0, 0.0, 0.0), *(a.inverse() @ b for a, b in pairwise(odometry))]
    for pose, motion in zip(path, motions, strict=True):
        yield cpu_time(slam.track, motion, room.scan(pose, rng))


def by_lamps(room: FurnishedRoom, path: list[SE2], odometry: list[SE2], rng: np.random.Generator) -> Iterator[Answer]:
    """Yield the poses of a drive by lamps and odometry; the time is that of the pose from found lamps."""
    tracker = BeaconTracker(BEACONS, MOUNT, None, replace(EXACT, tilt_sigma=TILT))
    for pose, wheels in zip(path, odometry, strict=True):
        view = view_from(pose, *rng.normal(0.0, TILT, 2))
        found = find_lamps(replace(view, visible=view.visible & ~room.occluded_lamps(pose)), LIGHT, rng)
        tracker.add_odometry(wheels)
        rays = tracker.locator.rays(CAMERA, found.ids, found.centres, found.sigmas)
        fix, milliseconds = cpu_time(tracker.track, rays)
        yield fix.T_map_base if isinstance(fix, BeaconFix) else None, milliseconds


def answers_in_room(seed: int, seconds: float) -> Iterator[tuple[str, str, Answer, SE2]]:
    """Yield the answers of both along the drives in one room: how it is furnished, who, what, and the truth."""
    rng = np.random.default_rng(seed)
    room, slam = furnished_room(rng), None
    states = {
        'first drive, SLAM': room,
        'later, as the map was made': room,
        'later, pieces pushed by 5-30 cm': move_furniture(room, rng),
        'later, all furniture elsewhere': furnished_room(rng),
    }
    paths, steps = [drive(rng) for _ in states], slice(0, round(seconds * RATE), EVERY)
    for path, _ in paths[:2]:
        states |= dict.fromkeys(list(states)[:2], without_obstacles(states['first drive, SLAM'], path[steps]))
    for (name, furnished), (poses, wheels) in zip(states.items(), paths, strict=True):
        path, odometry = poses[steps], wheels[steps]
        state = without_obstacles(furnished, path)
        guess = path[0] if slam is None else path[0] @ SE2(*(rng.uniform(-1.0, 1.0, 3) * GUESS).tolist())
        slam = LidarSlam(guess) if slam is None else slam.restarted(guess)
        for answer, truth in zip(by_lidar(slam, state, path, odometry, rng), path, strict=True):
            yield name, LIDAR, answer, truth
        for answer, truth in zip(by_lamps(state, path, odometry, rng), path, strict=True):
            yield name, LAMPS, answer, truth


def main(run: Run, rooms: int, seconds: float) -> None:
    """Compare lamps and lidar."""
    use_one_core()
    answers: dict[tuple[str, str], list[tuple[Answer, SE2]]] = {}
    for seed in progress(range(rooms), 'rooms'):
        for name, what, answer, truth in answers_in_room(seed, seconds):
            answers.setdefault((name, what), []).append((answer, truth))
    heads = 'cm: median / 95 % / max', f'off by more than {100.0 * FAR:g} cm', 'heading °: median / 95 %'
    table = run.table('Lamps and lidar, driven', 'drive', 'what', 'poses', *heads, 'ms of matching')
    for (name, what), given in answers.items():
        poses = [(pose, truth) for (pose, _), truth in given if pose is not None]
        errors = [pose.distance_to(truth) for pose, truth in poses]
        turns = [abs(pose.yaw_to(truth)) for pose, truth in poses]
        table.add(
            *(name, what, rate(len(poses), len(given)), error(errors, '.2f', 100.0)),
            rate(sum(off > FAR for off in errors), len(errors), 'lower'),
            error(turns, '.2f', math.degrees(1.0), (50, 95)),
            time([milliseconds for (_, milliseconds), _ in given], '.1f', (50,)),
        )


if __name__ == '__main__':
    run_benchmark(
        main, rooms=Option(5, 1, 'furnished rooms, four drives in each'), seconds=Option(30.0, 5.0, 'of each drive')
    )
