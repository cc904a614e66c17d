"""Lamps compared with a 2-D lidar scan matcher, before and after furniture moves.

Rooms of 7 x 6 m with furniture of chance under the paper's four lamps. The lidar's map is made of scans at exact poses;
then pieces are pushed, or all furniture is elsewhere. At the same places the lidar is matched from a first guess
within 10 cm and 5 degrees, and lamps that furniture does not hide are found in rendered images of the lit room, without
a guess: once by a camera that is exactly level, once by one whose tilt an IMU measures to 0.1 degrees.
"""

from __future__ import annotations

import math
from collections.abc import Iterator
from dataclasses import replace
from itertools import islice

import numpy as np
from _figures import error, rate, time
from _harness import Option, Run, cpu_time, progress, run_benchmark, use_one_core
from _lamp_finders import LampFinder
from _lamp_methods import EXACT
from _lamp_pictures import LIGHTS
from _lamp_room import BEACONS, CAMERA, MOUNT, View, random_views, view_from
from _lidar_matcher import ScanMatcher
from _lidar_room import BEAMS, FurnishedRoom, furnished_room, move_furniture

from shirube_core.geometry import SE2
from vlc_beacon.core.pose.beacon_locator import BeaconLocator
from vlc_beacon.core.pose.pose_fix import BeaconFix

MAP_SCANS = 60
GUESS, GUESS_TURN = 0.1, math.radians(5.0)
LIGHT = next(light for light in LIGHTS if light.name == 'lit room')
FAR = 0.05
"""Errors beyond it are counted [m]."""
TILT = math.radians(0.1)
"""Standard deviation of the unmeasured roll and pitch [rad]."""
LIDAR, LEVEL_LAMPS, LAMPS = f'lidar, {BEAMS} beams', 'lamps, tilt exact', 'lamps, tilt within 0.1°'

Answer = tuple[SE2 | None, float]
"""A pose or none, and the processor time [ms]."""


def by_lidar(matcher: ScanMatcher, room: FurnishedRoom, pose: SE2, rng: np.random.Generator) -> Answer:
    """Return where the lidar is."""
    x, y, turn = rng.uniform(-1.0, 1.0, 3) * (GUESS, GUESS, GUESS_TURN)
    return cpu_time(matcher.match, room.scan(pose, rng), SE2(pose.x + x, pose.y + y, pose.yaw + turn))


def by_lamps(
    finder: LampFinder, locator: BeaconLocator, room: FurnishedRoom, view: View, rng: np.random.Generator
) -> Answer:
    """Return where the camera is; the time is that of the pose from found lamps."""
    unhidden = replace(view, visible=view.visible & ~room.occluded_lamps(view.pose))
    found = finder.find(unhidden, LIGHT, rng)
    rays = locator.rays(CAMERA, found.ids, found.centres, found.sigmas)
    fix, milliseconds = cpu_time(locator.locate, rays)
    return fix.T_map_base if isinstance(fix, BeaconFix) else None, milliseconds


def answers_in_room(seed: int, places: int) -> Iterator[tuple[str, str, Answer, SE2]]:
    """Yield the answers of all at places of one room: how it is furnished, who answers, what, and the truth."""
    rng = np.random.default_rng(seed)
    room, finder = furnished_room(rng), LampFinder()
    level, leaning = (
        BeaconLocator(BEACONS, MOUNT, None, replace(EXACT, tilt_sigma=sigma)) for sigma in (0.0, TILT)
    )
    free = [view.pose for view in random_views(4 * MAP_SCANS, rng) if room.is_free(view.pose)]
    matcher = ScanMatcher((pose, room.scan(pose, rng)) for pose in free[:MAP_SCANS])
    states = {
        'as the map was made': room,
        'pieces pushed by 5–30 cm': move_furniture(room, rng),
        'all furniture elsewhere': furnished_room(rng),
    }
    usable = (
        view
        for view in random_views(100 * places, rng)
        if view.visible.sum() >= 2 and all(state.is_free(view.pose) for state in states.values())
    )
    for view in islice(usable, places):
        leaned = view_from(view.pose, *rng.normal(0.0, TILT, 2))
        for name, state in states.items():
            yield name, LIDAR, by_lidar(matcher, state, view.pose, rng), view.pose
            yield name, LEVEL_LAMPS, by_lamps(finder, level, state, view, rng), view.pose
            yield name, LAMPS, by_lamps(finder, leaning, state, leaned, rng), view.pose


def main(run: Run, rooms: int, places: int) -> None:
    """Compare lamps and lidar."""
    use_one_core()
    answers: dict[tuple[str, str], list[tuple[Answer, SE2]]] = {}
    for seed in progress(range(rooms), 'rooms'):
        for name, what, answer, truth in answers_in_room(seed, places):
            answers.setdefault((name, what), []).append((answer, truth))
    heads = 'cm: median / 95 % / max', f'off by more than {100.0 * FAR:g} cm', 'heading °: median / 95 %'
    table = run.table('Lamps and lidar', 'furniture', 'what', 'poses', *heads, 'ms of matching')
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
        main, rooms=Option(10, 1, 'furnished rooms'), places=Option(20, 6, 'in each, under two lamps or more')
    )
