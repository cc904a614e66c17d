"""How many images a second a receiver under lamps takes on one core: `./shirube bench lamp_speed`.

Films of 1280 x 1024 pixels are rendered image by image; the whole receiver takes each of them (detection, tracks,
packets, pose, commands), and in turn OpenCV looks for ArUco markers in it and in a picture with four markers in the
lamps' places. Process time of one process on one core. Run it twice: the first run compiles.
"""

from __future__ import annotations

import argparse
import os
import time
from collections.abc import Callable
from dataclasses import dataclass, field
from functools import partial

os.environ['OPENBLAS_NUM_THREADS'] = '1'

import numpy as np
from _lamp_films import BEACONS, FILMS, Film, receive_frames, receiver_for, simulate_drive
from _lamp_markers import Markers, is_available
from _lamp_pictures import LIGHTS
from _lamp_report import format_centimetres
from _lamp_room import view_from
from _timed_answers import use_one_core
from numpy.typing import NDArray
from tqdm import tqdm

from scene_simulator.ceiling.camera import PAPER_OPTICS
from shirube_core.geometry import SE2
from vlc_beacon.core.authorization.decision import Accepted
from vlc_beacon.core.lamp_image.lamp_detector import LampDetector
from vlc_beacon.core.pose.pose_fix import BeaconFix
from vlc_beacon.core.receiver.beacon_receiver import ReceiverOutput

WARM_UP = 10
"""Images before the clock counts."""
WANTED = 60.0
"""Images a second of the camera."""
WHOLE, DETECTOR, ARUCO, MARKED = range(4)


@dataclass
class Run:
    """What a film gave.

    Attributes:
        times: CPU time of each image: whole receiver, detector alone, ArUco on the image, ArUco on markers [ms].
        errors: position errors of the poses [m].
        named: the most lamps with an ID in an image.
        commands: number of accepted commands.
        images: number of images of the film.
    """

    times: list[tuple[float, float, float, float]] = field(default_factory=list)
    errors: list[float] = field(default_factory=list)
    named: int = 0
    commands: int = 0
    images: int = 0

    def add(self, output: ReceiverOutput, truth: SE2) -> None:
        """Take what the receiver made of an image."""
        self.images += 1
        self.named = max(self.named, sum(lamp.beacon is not None for lamp in output.lamps))
        self.commands += sum(isinstance(decision.outcome, Accepted) for decision in output.decisions)
        if isinstance(output.result, BeaconFix):
            self.errors.append(output.result.T_map_base.distance_to(truth))


def milliseconds(work: Callable[[], object]) -> float:
    """Return the process time of some work [ms]."""
    begin = time.process_time()
    work()
    return 1e3 * (time.process_time() - begin)


def run_film(film: Film, seconds: float) -> Run:
    """Return what a film gave."""
    run, drive, receiver, detector = Run(), simulate_drive(film), receiver_for(film), LampDetector()
    markers = Markers('ArUco 4x4', sensitive=False) if is_available() else None
    marked = marked_picture(markers, drive.pose_at(0.0)) if markers else None
    frames = receive_frames(drive, receiver, seconds)
    for frame in tqdm(frames, film.name, drive.frame_count(seconds), leave=False):
        image = frame.photo.image
        begin = time.process_time()
        output = receiver.receive(frame.stamp, image, PAPER_OPTICS)
        whole = 1e3 * (time.process_time() - begin)
        alone = milliseconds(partial(detector.detect, image))
        peer = on_markers = np.nan
        if markers is not None and marked is not None:
            peer = milliseconds(partial(markers.find, image))
            on_markers = milliseconds(partial(markers.find, marked))
        run.times.append((whole, alone, peer, on_markers))
        run.add(output, frame.pose)
    return run


def marked_picture(markers: Markers, pose: SE2) -> NDArray[np.uint8]:
    """Return a lit room with markers in the lamps' places."""
    return markers.picture(view_from(pose), LIGHTS[1], np.random.default_rng(1))


def row_of(film: Film, run: Run) -> str:
    """Return a line of the table."""
    times = np.array(run.times[WARM_UP:])
    median, late = np.percentile(times[:, WHOLE], [50.0, 95.0])
    detector, aruco, marked = np.median(times[:, DETECTOR:], axis=0)
    return (
        f'| {film.name} | {median:.2f} / {late:.2f} | {1e3 / times[:, WHOLE].mean():.0f} | {detector:.2f} '
        f'| {aruco:.2f} / {marked:.2f} | {run.named} of {len(BEACONS)} | {run.commands} '
        f'| {len(run.errors)} of {run.images} | {format_centimetres(run.errors)} |'
    )


def main() -> int:
    """Print the table; return 1 when the receiver is slower than the camera."""
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument('--seconds', type=float, default=10.0, help='of each film')
    seconds = parser.parse_args().seconds
    use_one_core()
    print(
        '| video | receiver ms: median / 95 % | images a second | detector alone ms | ArUco ms: same image / markers '
        '| lamps named | commands | poses | error: median / 95 % / max cm |\n|---|---|---|---|---|---|---|---|---|'
    )
    rates = []
    for film in FILMS:
        run = run_film(film, seconds)
        rates.append(1e3 / float(np.mean(run.times[WARM_UP:], axis=0)[WHOLE]))
        print(row_of(film, run), flush=True)
    decision = 'reached' if min(rates) >= WANTED else 'missed'
    print(f'\nAt least {WANTED:.0f} images/s: {decision}, minimum {min(rates):.0f}.')
    return 0 if min(rates) >= WANTED else 1


if __name__ == '__main__':
    raise SystemExit(main())
