"""Accuracy of a survey of a rendered drive against the ground truth. Prints Markdown.

    shirube bench survey
    shirube bench survey --size 1.5 --sway
    shirube bench survey --growth 2.5 5 10

A robot with odometry 2 % too long and a yaw drift of 1 degree per metre drives over a square floor in lanes that
overlap by 20 %; the core of `build_map` makes the map, with its scale from one length measured 0.5 mm too long.
An interrupted survey resumes.
`--growth` measures instead time and memory of the pose graph and the adjustment on floors of several sizes with
simulated dots. With SHIRUBE_DATA the printed sheets of its photographs are surveyed as well.
"""

from __future__ import annotations

import argparse
import math
import os
import subprocess
import sys
import time
from pathlib import Path

import numpy as np
from _survey_growth import measure_growth
from _survey_scores import PoseScores, locate_on, wrong_merges
from _surveyed_floor import MOUNT, RenderedSurvey

from floor_localizer.commands.options import task_runner
from floor_localizer.core.settings import SurveySettings
from floor_localizer.core.survey.floor_survey import KnownLength, scale_survey
from floor_localizer.core.survey.map_comparison import MapComparison, compare
from floor_localizer.survey_files.checkpoint import Checkpoint
from floor_localizer.survey_files.survey_run import SurveyRun, run_survey
from scene_simulator.suspension import Suspension

PHOTOGRAPHS = Path(__file__).with_name('real_photographs') / 'survey_sheets.py'
TAPE_ERROR = 0.0005
SETTINGS = SurveySettings(image_step=0.45)


def main() -> int:
    """Survey, compare, locate, and print the tables."""
    options = parse()
    if options.growth:
        report_growth(options.growth, options.seed, options.workers)
        return 0
    suspension = Suspension(heave=0.0013, tilt=math.radians(0.5)) if options.sway else None
    survey = RenderedSurvey(options.size, options.seed, suspension)
    folder = Path(f'out/bench_survey/{options.size}_{options.seed}_{int(options.sway)}')
    start = time.perf_counter()
    with task_runner(options.workers) as runner:
        checkpoint = Checkpoint(folder, {'size': options.size, 'seed': options.seed})
        run = run_survey(survey, MOUNT, SETTINGS, checkpoint, runner)
    report(survey, run, options.size, time.perf_counter() - start, options.places)
    if 'SHIRUBE_DATA' not in os.environ:
        print('\nPrinted sheets in photographs: not surveyed, SHIRUBE_DATA names no folder of them.')
        return 0
    print('\nPrinted sheets in photographs:\n', flush=True)
    return subprocess.run([sys.executable, PHOTOGRAPHS], check=False).returncode


def report_growth(sizes: list[float], seed: int, workers: int) -> None:
    """Print time and memory of the pose graph and the adjustment on floors of several sizes."""
    print(
        '| floor m | images | observations | base MB | peak MB | above base, kB per image | peak of a worker MB '
        '| seconds | ms per image | image positions rms mm |\n|---|---|---|---|---|---|---|---|---|---|'
    )
    for size in sizes:
        grown = measure_growth(size, seed, SETTINGS, workers)
        above = (grown.peak - grown.base) / grown.images
        print(
            f'| {size:g} x {size:g} | {grown.images} | {grown.observations} | {grown.base / 1e6:.0f} | '
            f'{grown.peak / 1e6:.0f} | {above / 1e3:.1f} | '
            f'{f"{grown.worker_peak / 1e6:.0f}" if workers > 1 else "-"} | {grown.seconds:.0f} | '
            f'{1e3 * grown.seconds / grown.images:.1f} | {1e3 * grown.error:.4f} |',
            flush=True,
        )


def report(survey: RenderedSurvey, run: SurveyRun, size: float, seconds: float, places: int) -> None:
    """Print the tables of maps and poses."""
    before = compare(survey.true_map, run.result.dot_map)
    result, scale = scale_survey(run.result, measured_length(survey, run, before, size))
    after = compare(survey.true_map, result.dot_map)
    print(f'{size:g} x {size:g} m, {len(survey.true_map)} chips, {len(run.images)} images, {seconds:.0f} s\n')
    print(
        '| scale by | scale % | distance mm: rms / 95 % / max | common | missing | extra |\n|---|---|---|---|---|---|'
    )
    print(row('height of the camera', before))
    print(row(f'a length of {0.8 * size:g} m, 0.5 mm too long ({100 * (scale - 1):+.4f} %)', after))
    wrong, dots = wrong_merges(run, survey)
    print(
        f'\nLoop closures: {result.loop_closures}; images on the map: {len(result.images)} of {len(run.images)}; '
        f'spurious dots: {result.spurious_count}'
    )
    print(f'dots merged from observations of different true dots: {wrong} of {dots}.\n')
    print(
        '| map | found | matched % | error mm: median / 95 % | 50 mm step error mm: median / 95 % | error °: median |'
    )
    print('|---|---|---|---|---|---|')
    print(score_row('true', locate_on(survey, survey.true_map, None, places)))
    by_height = locate_on(survey, run.result.dot_map, before.T_first_second, places)
    print(score_row('surveyed, scale by the height', by_height))
    by_length = locate_on(survey, result.dot_map, after.T_first_second, places)
    print(score_row('surveyed, scale by the length', by_length))


def measured_length(survey: RenderedSurvey, run: SurveyRun, found: MapComparison, size: float) -> KnownLength:
    """Return the tape measurement between two dots that are 0.8 of the floor's side apart."""
    true = survey.floor.points[found.pairs[:, 0]]
    close = np.hypot(*found.residuals.T) < 2.0 * np.median(np.hypot(*found.residuals.T))
    ends = []
    for place in ((0.1 * size, 0.5 * size), (0.9 * size, 0.5 * size)):
        distance = np.where(close, np.hypot(*(true - place).T), np.inf)
        ends.append(int(np.argmin(distance)))
    first, second = run.result.dot_map.points[found.pairs[ends, 1]]
    return KnownLength(first, second, float(np.hypot(*(true[ends[1]] - true[ends[0]]))) + TAPE_ERROR)


def row(name: str, found: MapComparison) -> str:
    """Return a line of the table of maps."""
    lengths = 1e3 * np.hypot(*found.residuals.T)
    apart = f'{1e3 * found.rms:.3f} / {np.percentile(lengths, 95):.3f} / {lengths.max():.2f}'
    counts = f'{len(found.pairs)} | {len(found.missing)} | {len(found.extra)}'
    return f'| {name} | {100 * (found.scale - 1):+.4f} | {apart} | {counts} |'


def score_row(name: str, scores: PoseScores) -> str:
    """Return a line of the table of poses."""
    errors, steps = 1e3 * scores.errors, 1e3 * scores.step_errors
    return (
        f'| {name} | {len(errors)} of {scores.tried} | {100 * np.mean(scores.match_rates):.1f} | '
        f'{np.median(errors):.3f} / {np.percentile(errors, 95):.3f} | '
        f'{np.median(steps):.4f} / {np.percentile(steps, 95):.4f} | {np.degrees(np.median(scores.turns)):.4f} |'
    )


def parse() -> argparse.Namespace:
    """Return the options."""
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument(
        '--size', type=float, default=5.0, help='side of the floor [m] (default: %(default)s)'
    )
    parser.add_argument('--seed', type=int, default=3, help='default: %(default)s')
    parser.add_argument(
        '--places', type=int, default=100, help='number of located positions (default: %(default)s)'
    )
    parser.add_argument(
        '--workers', type=int, default=os.cpu_count() or 1, help='processes (default: all cores)'
    )
    parser.add_argument(
        '--sway', action='store_true', help='let the robot body heave by 1 %% and tilt by 0.5 degrees'
    )
    parser.add_argument(
        '--growth',
        type=float,
        nargs='+',
        metavar='SIZE',
        help='measure memory and time for floors of these sides instead [m]',
    )
    return parser.parse_args()


if __name__ == '__main__':
    sys.exit(main())
