"""Accuracy of a survey of a rendered drive against the ground truth.

A robot with odometry 2 % too long and a yaw drift of 1 degree per metre drives over a square floor in lanes that
overlap by 20 %; the core of `build_map` makes the map, with its scale from one length measured 0.5 mm too long.
An interrupted survey resumes.
"""

import math
import os
import resource
import time
from pathlib import Path

import numpy as np
from _figures import count, error, measured, rate, rms
from _harness import Option, Run, run_benchmark
from _surveyed_floor import CAMERA, MOUNT, RenderedSurvey
from numpy.typing import NDArray

from floor_localizer.commands.options import task_runner
from floor_localizer.core.constellation.indexed_map import index_map
from floor_localizer.core.dots import DotMap
from floor_localizer.core.fix import Fix
from floor_localizer.core.localizer import FloorLocalizer
from floor_localizer.core.settings import SurveySettings
from floor_localizer.core.survey.adjustment.observations import project_rays_to_map
from floor_localizer.core.survey.floor_survey import KnownLength, scale_survey
from floor_localizer.core.survey.map_comparison import MapComparison, compare
from floor_localizer.survey_files.checkpoint import Checkpoint
from floor_localizer.survey_files.survey_run import SurveyRun, run_survey
from shirube_core.geometry import SE2

TAPE_ERROR = 0.0005
SETTINGS = SurveySettings(image_step=0.45)
SAME_PLACE = 0.0015
EDGE = 0.15
STEP = SE2(0.05, 0.0, 0.0)


def add_maps(run: Run, size: float, maps: dict[str, MapComparison]) -> None:
    """Add how far the maps are from the true one."""
    heads = 'scale by | scale % | distance mm: rms | median / 95 % / max | common | missing | extra'
    table = run.table(f'Maps of {size:g} x {size:g} m', heads)
    for name, found in maps.items():
        distances, scale = np.hypot(*found.residuals.T), count(100 * (found.scale - 1), '+.4f')
        numbers = [count(len(found.pairs), better='higher')]
        numbers += [count(len(dots), better='lower') for dots in (found.missing, found.extra)]
        table.add(name, scale, rms(distances, '.3f', 1e3), error(distances, '.3f', 1e3), *numbers)


def add_survey(run: Run, survey: RenderedSurvey, found: SurveyRun, seconds: float) -> None:
    """Add what became of images and dots, and what it took."""
    heads = 'chips | loop closures | images on the map | wrong merges of dots | spurious dots | seconds'
    (wrong, dots), result = wrong_merges(found, survey), found.result
    peak = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss / 1024.0
    run.table('Survey', heads, 'peak memory MB').add(
        *(len(survey.true_map), count(result.loop_closures)),
        *(rate(len(result.images), len(found.images)), rate(wrong, dots, 'lower')),
        *(count(result.spurious_count), measured(seconds, '.0f'), measured(peak, '.0f')),
    )


def add_poses(run: Run, survey: RenderedSurvey, maps: dict[str, tuple[DotMap, SE2]], places: int) -> None:
    """Add how well images are located on the maps."""
    heads = 'map | found | error mm: median / 95 % | 50 mm step error mm: median / 95 % | error °: the same'
    table = run.table('Poses', heads)
    for name, (dot_map, T_true_map) in maps.items():
        errors, steps = locate_on(survey, dot_map, T_true_map, places)
        found, turns = rate(len(errors), 2 * places), error(errors[:, 1], '.4f', math.degrees(1.0), (50, 95))
        position, step = error(errors[:, 0], '.3f', 1e3, (50, 95)), error(steps, '.4f', 1e3, (50, 95))
        table.add(name, found, position, step, turns)


def measured_length(survey: RenderedSurvey, run: SurveyRun, found: MapComparison, size: float) -> KnownLength:
    """Return the tape measurement between two dots that are 0.8 of the floor's side apart."""
    true = survey.floor.points[found.pairs[:, 0]]
    close = np.hypot(*found.residuals.T) < 2.0 * np.median(np.hypot(*found.residuals.T))
    distances = (np.hypot(*(true - (share * size, 0.5 * size)).T) for share in (0.1, 0.9))
    ends = [int(np.argmin(np.where(close, distance, np.inf))) for distance in distances]
    first, second = run.result.dot_map.points[found.pairs[ends, 1]]
    return KnownLength(first, second, float(np.hypot(*(true[ends[1]] - true[ends[0]]))) + TAPE_ERROR)


def wrong_merges(run: SurveyRun, survey: RenderedSurvey) -> tuple[int, int]:
    """Return the number of dots merged from observations of different true dots, and the number of all dots."""
    numbers = [int(run.images.frames[k].name.split()[1]) for k in run.result.images]
    poses = np.array([(p.x, p.y, p.yaw, 0.0, 0.0, 0.0) for p in (survey.truth[k] for k in numbers)])
    wrong = dots = 0
    for block in run.result.blocks:
        observations = block.observations
        true = project_rays_to_map(observations.directions, np.array(MOUNT.xyz), poses[observations.image])
        number = np.maximum(np.bincount(observations.dot), 1)
        means = np.column_stack([np.bincount(observations.dot, true[:, k]) / number for k in range(2)])
        far = np.hypot(*(true - means[observations.dot]).T) > SAME_PLACE
        wrong += len(np.unique(observations.dot[far]))
        dots += len(np.unique(observations.dot))
    return wrong, dots


def locate_on(
    survey: RenderedSurvey, dot_map: DotMap, T_true_map: SE2, places: int
) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """Locate rendered images, two at each place 50 mm apart, without a prior.

    Return errors of position [m] and heading [rad] of those located, shape (n, 2), and of the steps [m], shape (m,).
    """
    localizer, rng = FloorLocalizer(index_map(dot_map), MOUNT), np.random.default_rng(11)
    size = survey.floor.design.size
    errors, steps = [], []
    for number in range(places):
        x, y = rng.uniform(EDGE, np.array(size) - EDGE)
        start = SE2(float(x), float(y), float(rng.uniform(-math.pi, math.pi)))
        found = []
        for k, pose in enumerate((start, start @ STEP)):
            fix = localizer.locate(survey.photograph(pose, 100_000 + 2 * number + k), CAMERA)
            if isinstance(fix, Fix):
                found.append(T_true_map @ fix.T_map_base)
                errors.append((found[-1].distance_to(pose), abs(found[-1].yaw_to(pose))))
        if len(found) == 2:
            steps.append((found[0].inverse() @ found[1]).distance_to(STEP))
    return np.array(errors).reshape(-1, 2), np.array(steps)


def main(run: Run, size: float, places: int, workers: int) -> None:
    """Survey a rendered floor, compare its maps with the true one, and locate images on them."""
    survey = RenderedSurvey(size, run.seed)
    folder, start = Path(f'out/bench_survey/{size}_{run.seed}'), time.perf_counter()
    with task_runner(workers) as runner:
        checkpoint = Checkpoint(folder, {'size': size, 'seed': run.seed})
        found = run_survey(survey, MOUNT, SETTINGS, checkpoint, runner)
    seconds = time.perf_counter() - start
    before = compare(survey.true_map, found.result.dot_map)
    result, _ = scale_survey(found.result, measured_length(survey, found, before, size))
    after = compare(survey.true_map, result.dot_map)
    by_length = f'a length of {0.8 * size:g} m, 0.5 mm too long'
    add_maps(run, size, {'height of the camera': before, by_length: after})
    add_survey(run, survey, found, seconds)
    maps = {
        'true': (survey.true_map, SE2(0.0, 0.0, 0.0)),
        'surveyed, scale by the height': (found.result.dot_map, before.T_first_second),
        'surveyed, scale by the length': (result.dot_map, after.T_first_second),
    }
    add_poses(run, survey, maps, places)


if __name__ == '__main__':
    run_benchmark(
        main,
        size=Option(5.0, 0.8, 'side of the floor [m]'),
        places=Option(100, 15, 'located positions'),
        workers=Option(1, os.cpu_count() or 1, 'processes'),
    )
