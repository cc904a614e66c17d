"""How many images a second a receiver under lamps takes on one core, beside OpenCV's ArUco detector.

Films of 1280 x 1024 pixels are rendered image by image; the whole receiver takes each of them (detection, tracks,
packets, pose, commands), and in turn OpenCV looks for ArUco markers in it and in a picture with four markers in the
lamps' places. Process time of one process on one core, without the first images, which compile.
"""

from __future__ import annotations

import numpy as np
from _figures import count, error, measured, rate, ratio, time
from _harness import Option, Run, cpu_time, progress, run_benchmark, use_one_core
from _lamp_films import BEACONS, FILMS, receive_frames, receiver_for, simulate_drive
from _lamp_markers import Markers, is_available
from _lamp_pictures import LIGHTS
from _lamp_room import view_from

from scene_simulator.ceiling_camera import PAPER_OPTICS
from vlc_beacon.core.authorization.decision import Accepted
from vlc_beacon.core.lamp_image.lamp_detector import LampDetector
from vlc_beacon.core.pose.pose_fix import BeaconFix

WARM_UP = 10
"""Images that are not counted."""


def main(run: Run, seconds: float, films: int) -> None:
    """Show the films to the receiver."""
    use_one_core()
    heads = (
        'receiver ms: median / 95 %',
        'images a second',
        'detector alone ms',
        'ArUco ms',
        'receiver over ArUco',
    )
    table = run.table('Speed', 'film', *heads, 'ArUco on markers ms')
    results = run.table('Results', 'film', 'lamps named', 'commands', 'poses', 'cm: median / 95 % / max')
    markers = Markers('ArUco 4x4', sensitive=False) if is_available() else None
    for film in FILMS[:films]:
        drive, receiver, detector = simulate_drive(film), receiver_for(film), LampDetector()
        times: dict[str, list[float]] = {'receiver': [], 'detector': [], 'peer': [], 'marked': []}
        errors, named, commands = list[float](), 0, 0
        if markers is not None:
            marked = markers.picture(view_from(drive.pose_at(0.0)), LIGHTS[1], np.random.default_rng(1))
        frames = receive_frames(drive, receiver, seconds)
        for frame in progress(frames, film.name, drive.frame_count(seconds)):
            image = frame.photo.image
            output, milliseconds = cpu_time(receiver.receive, frame.stamp, image, PAPER_OPTICS)
            times['receiver'].append(milliseconds)
            times['detector'].append(cpu_time(detector.detect, image)[1])
            if markers is not None:
                times['peer'].append(cpu_time(markers.find, image)[1])
                times['marked'].append(cpu_time(markers.find, marked)[1])
            named = max(named, sum(lamp.beacon is not None for lamp in output.lamps))
            commands += sum(isinstance(decision.outcome, Accepted) for decision in output.decisions)
            if isinstance(output.result, BeaconFix):
                errors.append(output.result.T_map_base.distance_to(frame.pose))
        number, times = len(times['receiver']), {name: each[WARM_UP:] for name, each in times.items()}
        peers: list[object] = ['–'] * 3
        if markers is not None:
            peers = [
                time(times['peer']),
                ratio(times['receiver'], times['peer'], '.2f'),
                time(times['marked']),
            ]
        rate_of_images = measured(1e3 / float(np.mean(times['receiver'])), '.0f')
        table.add(
            film.name, time(times['receiver']), rate_of_images, time(times['detector'], '.2f', (50,)), *peers
        )
        results.add(
            *(
                film.name,
                rate(named, len(BEACONS)),
                count(commands, better='higher'),
                rate(len(errors), number),
            ),
            error(errors, '.2f', 100.0),
        )


if __name__ == '__main__':
    run_benchmark(main, seconds=Option(8.0, 1.2, 'of each film'), films=Option(len(FILMS), 2, 'of them'))
