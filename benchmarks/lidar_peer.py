"""Lamps compared with a 2-D lidar scan matcher, before and after furniture moves: `./shirube bench lidar_peer`.

Rooms of 7 x 6 m with furniture of chance under the paper's four lamps. The lidar's map is made of scans at exact poses;
then pieces are pushed, or all furniture is elsewhere. At the same places the lidar is matched from a first guess
within 10 cm and 5 degrees, and lamps that furniture does not hide are found in rendered images of the lit room, without
a guess: once by a camera that is exactly level, once by one whose tilt an IMU measures to 0.1 degrees.
"""

from __future__ import annotations

import argparse
import math
import os
import time
from collections.abc import Iterator
from dataclasses import dataclass, field, replace
from itertools import islice
from typing import NamedTuple

os.environ['OPENBLAS_NUM_THREADS'] = '1'

import numpy as np
from _lamp_finders import LampFinder
from _lamp_methods import EXACT
from _lamp_pictures import LIGHTS
from _lamp_report import format_centimetres
from _lamp_room import BEACONS, CAMERA, MOUNT, View, random_views, view_from
from _lidar_matcher import ScanMatcher
from _lidar_room import BEAMS, RANGE_NOISE, FurnishedRoom, furnished_room, move_furniture
from _timed_answers import use_one_core
from tqdm import tqdm

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


class Answer(NamedTuple):
    """A pose or none, and the time it took [s]."""

    pose: SE2 | None
    seconds: float


@dataclass
class Score:
    """Errors at places: in the plane [m], of the heading [rad]; how many places there were; times [ms]."""

    errors: list[float] = field(default_factory=list)
    turns: list[float] = field(default_factory=list)
    places: int = 0
    times: list[float] = field(default_factory=list)

    def add(self, answer: Answer, truth: SE2) -> None:
        """Take an answer."""
        self.places += 1
        self.times.append(1e3 * answer.seconds)
        if answer.pose is not None:
            self.errors.append(answer.pose.distance_to(truth))
            self.turns.append(abs(answer.pose.yaw_to(truth)))

    def cells(self) -> str:
        """Return the cells of a line."""
        far = sum(error > FAR for error in self.errors)
        turn = np.degrees(np.percentile(self.turns, [50.0, 95.0])) if self.turns else (math.nan, math.nan)
        return (
            f'{len(self.errors)} of {self.places} | {format_centimetres(self.errors)} | {far} '
            f'| {turn[0]:.2f} / {turn[1]:.2f} | {np.median(self.times):.1f}'
        )


def map_of(room: FurnishedRoom, rng: np.random.Generator) -> ScanMatcher:
    """Return a matcher whose map was made in a room."""
    free = [view.pose for view in random_views(4 * MAP_SCANS, rng) if room.is_free(view.pose)]
    return ScanMatcher((pose, room.scan(pose, rng)) for pose in free[:MAP_SCANS])


def by_lidar(matcher: ScanMatcher, room: FurnishedRoom, pose: SE2, rng: np.random.Generator) -> Answer:
    """Return where the lidar is."""
    x, y, turn = rng.uniform(-1.0, 1.0, 3) * (GUESS, GUESS, GUESS_TURN)
    scan = room.scan(pose, rng)
    begin = time.process_time()
    found = matcher.match(scan, SE2(pose.x + x, pose.y + y, pose.yaw + turn))
    return Answer(found, time.process_time() - begin)


def by_lamps(
    finder: LampFinder, locator: BeaconLocator, room: FurnishedRoom, view: View, rng: np.random.Generator
) -> Answer:
    """Return where the camera is; the time is that of the pose from found lamps."""
    unhidden = replace(view, visible=view.visible & ~room.occluded_lamps(view.pose))
    found = finder.find(unhidden, LIGHT, rng)
    begin = time.process_time()
    fix = locator.locate(locator.rays(CAMERA, found.ids, found.centres, found.sigmas))
    pose = fix.T_map_base if isinstance(fix, BeaconFix) else None
    return Answer(pose, time.process_time() - begin)


def answers_in_room(seed: int, places: int) -> Iterator[tuple[str, str, Answer, SE2]]:
    """Yield the answers of all at places of one room: how it is furnished, who answers, what, and the truth."""
    rng = np.random.default_rng(seed)
    room, finder = furnished_room(rng), LampFinder()
    level, leaning = (
        BeaconLocator(BEACONS, MOUNT, None, replace(EXACT, tilt_sigma=sigma)) for sigma in (0.0, TILT)
    )
    matcher = map_of(room, rng)
    states = {
        'as the map was made': room,
        'pieces pushed by 5–30 cm': move_furniture(room, rng),
        'all furniture elsewhere': furnished_room(rng),
    }
    free = (
        view
        for view in random_views(100 * places, rng)
        if view.visible.sum() >= 2 and all(state.is_free(view.pose) for state in states.values())
    )
    for view in islice(free, places):
        leaned = view_from(view.pose, *rng.normal(0.0, TILT, 2))
        for name, state in states.items():
            yield name, LIDAR, by_lidar(matcher, state, view.pose, rng), view.pose
            yield name, LEVEL_LAMPS, by_lamps(finder, level, state, view, rng), view.pose
            yield name, LAMPS, by_lamps(finder, leaning, state, leaned, rng), view.pose


def main() -> int:
    """Print the table."""
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument('--rooms', type=int, default=10)
    parser.add_argument('--places', type=int, default=20, help='in each room, under two lamps or more')
    arguments = parser.parse_args()
    use_one_core()
    scores: dict[tuple[str, str], Score] = {}
    for seed in tqdm(range(arguments.rooms), 'rooms', leave=False):
        for name, what, answer, truth in answers_in_room(seed, arguments.places):
            scores.setdefault((name, what), Score()).add(answer, truth)
    print(
        f'{arguments.rooms} rooms, {100.0 * RANGE_NOISE:g} cm of range noise.\n\n'
        f'| furniture | what | poses | median / 95 % / max cm | off by more than {100.0 * FAR:g} cm '
        '| heading °: median / 95 % | ms of matching |\n|---|---|---|---|---|---|---|'
    )
    for (name, what), score in scores.items():
        print(f'| {name} | {what} | {score.cells()} |')
    return 0


if __name__ == '__main__':
    raise SystemExit(main())
