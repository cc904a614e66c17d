"""How many images a second a receiver under lamps takes on one core, beside OpenCV's ArUco detector.

Films of 1280 x 1024 pixels are rendered image by image; the whole receiver takes each of them (detection, tracks,
packets, pose, commands), and in turn OpenCV looks for ArUco markers in it and in a picture with four markers in the
lamps' places. Process time of one process on one core, without the first images, which compile.
"""

import math
from dataclasses import dataclass

import numpy as np
from _figures import count, error, measured, rate, ratio, time
from _harness import Option, Run, cpu_time, progress, run_benchmark, use_one_core
from _lamp_films import BEACONS, FILMS, Film, receive_frames, receiver_for, simulate_drive
from _lamp_markers import Markers, is_available
from _lamp_pictures import LIGHTS
from _lamp_room import view_from

from scene_simulator.ceiling.camera import PAPER_OPTICS
from vlc_beacon.core.authorization.command_authorizer import Accepted
from vlc_beacon.core.lamp_image.lamp_detector import LampDetector
from vlc_beacon.core.pose.pose_fix import BeaconFix
from vlc_beacon.core.settings import AuthorizationSettings

AUTHORIZATION = AuthorizationSettings(zone_radius=math.hypot(*BEACONS[3].xyz[:2]))  # wherever the robot is
WARM_UP = 10  # images that are not counted
NEAR = 6.0  # A lamp is named rightly if its named place is that near to it [px]
DARK = 20  # A place of the lit ceiling is behind a person below this level [grey levels]


@dataclass
class FilmRun:
    """Times of each image [ms], without the first ones, and what the receiver made of a film."""

    times: dict[str, list[float]]
    errors: list[float]
    images: int = 0
    named: int = 0
    commands: int = 0
    hidden: int = 0
    shown: int = 0
    wrong: int = 0


def run_film(film: Film, seconds: float, markers: Markers | None) -> FilmRun:
    """Show a film to the receiver, and its images to the detector alone and to ArUco."""
    drive, receiver, detector = simulate_drive(film), receiver_for(film.channel, AUTHORIZATION), LampDetector()
    found = FilmRun({name: [] for name in ('receiver', 'detector', 'peer', 'marked')}, [])
    if markers is not None:
        marked = markers.picture(view_from(drive.pose_at(0.0)), LIGHTS[1], np.random.default_rng(1))
    frames = receive_frames(drive, receiver, seconds)
    for frame in progress(frames, film.name, drive.frame_count(seconds)):
        image = frame.photo.image
        output, milliseconds = cpu_time(receiver.receive, frame.stamp, image, PAPER_OPTICS)
        taken = {'receiver': milliseconds, 'detector': cpu_time(detector.detect, image)[1]}
        if markers is not None:
            taken |= {'peer': cpu_time(markers.find, image)[1], 'marked': cpu_time(markers.find, marked)[1]}
        found.images += 1
        if found.images > WARM_UP:
            for name, value in taken.items():
                found.times[name].append(value)
        true = {projection.lamp + 1: projection.centre for projection in frame.photo.lamp_projections}
        found.wrong += sum(
            lamp.beacon is not None
            and not np.hypot(*(lamp.sample.centre - true.get(lamp.beacon, (-99.0, -99.0)))) < NEAR
            for lamp in output.lamps
        )
        if film.people:
            seen = [image[round(true[b.id][1]), round(true[b.id][0])] for b in BEACONS if b.id in true]
            found.shown, found.hidden = (found.shown + len(seen), found.hidden + int(np.sum(np.array(seen) < DARK)))
        found.named = max(found.named, sum(lamp.beacon is not None for lamp in output.lamps))
        found.commands += sum(isinstance(decision.outcome, Accepted) for decision in output.decisions)
        if isinstance(output.result, BeaconFix):
            found.errors.append(output.result.T_map_base.distance_to(frame.pose))
    return found


def main(run: Run, seconds: float, films: int) -> None:
    """Show the films to the receiver."""
    use_one_core()
    heads = ('receiver ms: median / 95 %', 'images a second', 'detector alone ms', 'ArUco ms', 'receiver over ArUco')
    table = run.table('Speed', 'film', *heads, 'ArUco on markers ms')
    results_heads = 'lamps named | commands | behind people | wrong IDs | poses | cm: median / 95 % / max'
    results = run.table('Results', f'film | {results_heads}')
    markers = Markers('ArUco 4x4', sensitive=False) if is_available() else None
    for film in FILMS[:films]:
        found = run_film(film, seconds, markers)
        receiver, detector, peer, marked = found.times.values()
        units = ratio(receiver, peer, '.2f') if peer else '–'
        images_a_second = measured(1e3 / float(np.mean(receiver)), '.0f')
        table.add(
            *(film.name, time(receiver), images_a_second, time(detector, '.2f', (50,))),
            *(time(peer), units, time(marked)),
        )
        results.add(
            *(film.name, rate(found.named, len(BEACONS)), count(found.commands, better='higher')),
            rate(found.hidden, found.shown) if film.people else '–',
            count(found.wrong, better='lower'),
            *(rate(len(found.errors), found.images), error(found.errors, '.2f', 100.0)),
        )


if __name__ == '__main__':
    run_benchmark(main, seconds=Option(8.0, 1.2, 'of each film'), films=Option(len(FILMS), 2, 'of them'))
