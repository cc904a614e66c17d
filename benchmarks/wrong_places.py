"""Images of other places, which must give no pose, and of a machine that stands still.

Real: the two places and the still frames of the machine hall, and the room of EuRoC V1_01, each against the others.
Rendered: corridors against other corridors, and a room whose walls are alike, from anywhere in it.
"""

import math
from collections import Counter
from collections.abc import Iterator
from dataclasses import replace
from pathlib import Path
from tempfile import TemporaryDirectory

import numpy as np
from _figures import count, measured, rate
from _harness import Option, Run, progress, run_benchmark
from _landmark_corridor import TAUGHT, teach_corridor
from _real_pairs import Moment, find_by_targets, load_real_pairs
from _stereo_scenes import RIG, Pair, random_offset
from _target_choice import TargetChooser
from machine_hall import RIGHT_POSITION, Hall, teach

from scene_simulator.corridor.generator import CorridorDesign, corridor
from scene_simulator.corridor.stereo_rig import render_pair
from scene_simulator.mission.layout import ROOM
from scene_simulator.mission.sensors import MissionSensors
from shirube_bringup.building import teach_places
from shirube_bringup.render_worker import PiecewisePath
from shirube_core.geometry import SE2
from stereo_landmark.core.landmark_localizer import LandmarkFix, LandmarkLocalizer
from stereo_landmark.core.pair.camera_pair import Rectifier, stereo_rig
from stereo_landmark.core.procedure.taught_place import TaughtPlace
from stereo_landmark.core.stereo import StereoRig
from stereo_landmark.files.camera_files import load_camera_calibration, load_grey_image
from stereo_landmark.files.place_file import load_places

TILT = (-0.0045, 0.3930)  # roll and pitch of the still machine [rad]
OFFSET, TURN = 0.5, 0.26  # of the views of other corridors [m, rad]


def still_frames(folder: Path, hall: Hall) -> tuple[StereoRig, list[Moment]]:
    """Return the cameras and the rectified pairs of the machine that stands still."""
    first, second = (load_camera_calibration(folder / f'euroc_{side}.yaml') for side in ('left', 'right'))
    rectifiers = Rectifier(first), Rectifier(second)
    moments = []
    for path in sorted((folder / 'static').glob('*_left.png')):
        paths = path, path.with_name(path.name.replace('_left', '_right'))
        left, right = (each.rectify(load_grey_image(path)) for each, path in zip(rectifiers, paths, strict=True))
        moments.append(Moment(left, right, np.zeros(3), (*TILT, 0.0)))
    return stereo_rig(first, second, hall.mount), moments


def is_found(place: TaughtPlace, moment: Moment, rig: StereoRig) -> bool:
    """Return whether a pair of these cameras is located at a place."""
    localizer = LandmarkLocalizer([replace(place, rig=rig)])
    return isinstance(localizer.locate(moment.left, moment.right, moment.tilt), LandmarkFix)


def rendered_views(corridors: int, views: int) -> Iterator[tuple[TaughtPlace, Pair]]:
    """Yield places with views of the corridors after them, each of another seed."""
    for seed in range(corridors):
        place = teach_corridor(corridor(CorridorDesign(seed=seed))).place
        for number in range(views):
            rng = np.random.default_rng((seed, number))
            other = corridor(CorridorDesign(seed=corridors + seed * views + number))
            yield place, render_pair(other, RIG, TAUGHT @ random_offset(OFFSET, TURN, rng), rng)


def add_room(run: Run, views: int) -> None:
    """Add how often a robot anywhere in the mission's room, whose walls have one texture, is right, wrong or lost."""
    with TemporaryDirectory() as folder:
        teach_places(Path(folder))
        localizer = LandmarkLocalizer(load_places(Path(folder)))
    sensors, rng, outcomes = MissionSensors(run.seed, {}), np.random.default_rng(run.seed), Counter[str]()
    for number in progress(range(views)):
        true = SE2(*rng.uniform((0.5, 0.5, -math.pi), (ROOM[3] - 0.5, ROOM[4] - 0.5, math.pi)).tolist())
        still = PiecewisePath((0.0, float(views)), (true, true))
        pair = sensors.stereo_pair(number, float(number), still.pose_at)
        _, roll, pitch = sensors.suspension.motion_at(float(number)).tolist()
        fix = localizer.locate(*pair, (roll, pitch))
        found = fix.T_map_base if isinstance(fix, LandmarkFix) else None
        is_right = found is not None and found.distance_to(true) < RIGHT_POSITION
        outcomes['none' if found is None else 'right' if is_right else 'wrong'] += 1
    table = run.table('A room with alike walls', 'views | right | none | wrong')
    table.add(views, *(count(outcomes[each]) for each in ('right', 'none')), count(outcomes['wrong'], better='lower'))


def add_still(run: Run, place: TaughtPlace, moments: list[Moment]) -> None:
    """Add how often a still machine is found, and the spread of its poses."""
    localizer = LandmarkLocalizer([place])
    places = np.array([find_by_targets(localizer, moment)[0][:3] for moment in moments])
    found = places[np.isfinite(places[:, 0])]
    apart = 1e3 * np.linalg.norm(found - np.median(found, axis=0), axis=1)
    table = run.table('Standing still', 'found | distance from the median mm: median | max')
    table.add(rate(len(found), len(moments)), measured(float(np.median(apart)), '.1f'), measured(apart.max(), '.1f'))


def main(run: Run, step: int, corridors: int, views: int, room_views: int) -> None:
    """Show all places the images of the others."""
    folder = run.data('stereo_machine_hall')
    hall, pairs = Hall(folder), load_real_pairs(run.data('stereo_euroc'))
    rig, still = still_frames(folder, hall)
    euroc = pairs.moments['teach']
    taught = {name: teach(hall, name) for name in progress(list(hall.moments)[::step])}
    places = {name: place for name, place in taught.items() if place is not None}
    places |= {'still': TargetChooser(still[0], rig).place(0), 'room': TargetChooser(euroc, pairs.rig).place(0)}
    shown = [(name, moment, hall.rigs[name]) for name, moment in hall.moments.items()]
    shown += [('still', moment, rig) for moment in still]
    shown += [('room', moment, pairs.rig) for moment in pairs.moments.values()]
    table = run.table('Other places', 'images | pairs shown | found')
    # The first letter names the place in the hall; the still machine stands in the room of EuRoC V1_01.
    room = {'still', 'room'}
    others = [
        (place, moment, cameras)
        for name, place in places.items()
        for other, moment, cameras in shown
        if (name in room) is not (other in room) or (name not in room and name[0] != other[0])
    ]
    false = sum(is_found(*each) for each in progress(others))
    table.add('real', count(len(others)), count(false, better='lower'))
    false = total = 0
    for place, pair in progress(rendered_views(corridors, views), total=corridors * views):
        false += isinstance(LandmarkLocalizer([place]).locate(*pair), LandmarkFix)
        total += 1
    table.add('rendered corridors', count(total), count(false, better='lower'))
    add_still(run, places['still'], still[1:])
    add_room(run, room_views)


if __name__ == '__main__':
    run_benchmark(
        main,
        step=Option(1, 12, 'every so many places of the hall'),
        corridors=Option(40, 1, 'taught'),
        views=Option(30, 2, 'of other corridors for each'),
        room_views=Option(400, 4, 'in the room with alike walls'),
    )
