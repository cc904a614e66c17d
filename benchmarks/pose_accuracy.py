"""Poses from rendered images against the truth and against their stated covariances.

The demo's floor (91 582 irregular chips) and camera at places and headings that fill the floor evenly; each image
is located without a prior, and again with one that is 2 mm and 1 degree off, as a tracked robot has it. The map is
exact, so that the noise of the centroids is all there is, or surveyed to 0.05 mm, as the demo's.

The paper's experiment (3.2.1): a camera that a linear actuator moves 50 times by 12 mm, located at 51 places.
"""

import math
from collections.abc import Iterator
from dataclasses import dataclass

import cv2
import numpy as np
from _figures import mean, outcomes, rate, rms
from _floor_photographs import CAMERA, MOUNT, Outcome, SurveyedFloor
from _harness import Option, Run, progress, run_benchmark
from _pose_scores import pose_cells, whitened_errors
from numpy.typing import NDArray

from floor_localizer.core.fix import Fix
from scene_simulator.floor.camera import FloorCamera
from scene_simulator.floor.dot_floor import SURVEY_ERROR
from scene_simulator.robot.leg_drive import apply_body_motion
from shirube_core.geometry import SE2, wrap_angle

PHOTOGRAPHER = FloorCamera(CAMERA)
RISE, TILT = 0.05, math.radians(2.0)
PLACES, STEP = 51, 0.012
REPEATABILITY = 0.00002  # of the actuator, greatest error of a place along its axis [m]


@dataclass(frozen=True)
class Condition:
    """How the robot sways: rise of the camera as a fraction of its height, tilt about an axis that rotates [rad]."""

    name: str
    rise: float = 0.0
    tilt: float = 0.0


CONDITIONS = (
    Condition('nominal'),
    Condition('5 % too high', rise=RISE),
    Condition('5 % too low', rise=-RISE),
    Condition('tilted by 2°', tilt=TILT),
    Condition('5 % too high, tilted by 2°', rise=RISE, tilt=TILT),
    Condition('5 % too low, tilted by 2°', rise=-RISE, tilt=TILT),
)


def photographs(
    floor: SurveyedFloor, condition: Condition, count: int, seed: int
) -> Iterator[tuple[NDArray[np.uint8], SE2]]:
    """Yield the images of a condition and the true poses."""
    for number, pose in enumerate(floor.places(count)):
        axis = math.tau * number / math.sqrt(5.0)
        tilt = condition.tilt * math.cos(axis), condition.tilt * math.sin(axis)
        mount = apply_body_motion(MOUNT, condition.rise * MOUNT.xyz[2], *tilt)
        rng = np.random.default_rng([seed, number])
        yield PHOTOGRAPHER.photograph(floor.floor, [pose], mount, rng=rng).image, pose


def outcome(floor: SurveyedFloor, condition: Condition, count: int, seed: int) -> Outcome:
    """Locate all images of a condition."""
    return floor.outcome(progress(photographs(floor, condition, count, seed), condition.name, count))


def add_errors(run: Run, floor: SurveyedFloor, conditions: list[Condition], places: int) -> None:
    """Add the errors on one map."""
    table = run.table(
        'Map surveyed to 0.05 mm' if floor.survey_error else 'Map exact',
        'condition | right / none / wrong | tracked | position µm: median / 95 % / max | heading °: the same',
        'error / stated | error / stated, tracked',
    )
    for condition in conditions:
        found = outcome(floor, condition, places, run.seed)
        verdicts, position, heading = pose_cells(found.scores, '.1f', '.4f', 1e6, (50, 95, 100))
        tracked = outcomes(score.verdict for score in found.tracked)
        stated = (rms(whitened_errors(each), '.2f', better='one') for each in (found.scores, found.tracked))
        table.add(condition.name, verdicts, tracked, position, heading, *stated)


def deviations(found: list[SE2]) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """Return what the paper measures: distances from even places on the line fitted to all [m], and turns from the
    mean heading [rad].
    """
    places = np.array([(pose.x, pose.y) for pose in found])
    steps = np.arange(len(found)) - 0.5 * (len(found) - 1)
    off = places - places.mean(axis=0)
    direction = np.linalg.svd(off, full_matrices=False)[2][0]
    direction *= np.sign(direction @ (off[-1] - off[0]))
    ideal = STEP * steps[:, None] * direction
    turns = [wrap_angle(pose.yaw - found[0].yaw) for pose in found]
    return np.hypot(*(off - ideal).T), np.array(turns) - np.mean(turns)


def add_experiment(run: Run, floor: SurveyedFloor, lines: int) -> None:
    """Add the paper's figures and ours: over several lines, and with their errors against the truth."""
    rng = np.random.default_rng(run.seed)
    away, turned, errors, number = [], [], [], 0
    for start in progress(floor.places(lines), 'lines', lines):
        # The line begins where it ends on the floor, whatever its heading.
        ahead = SE2(start.x, start.y, math.atan2(4.725 - start.y, 0.9 - start.x))
        ways = STEP * np.arange(PLACES) + rng.uniform(-REPEATABILITY, REPEATABILITY, PLACES)
        poses = [ahead @ SE2(float(way), 0.0, 0.0) for way in ways]
        images = (PHOTOGRAPHER.photograph(floor.floor, [pose], rng=rng).image for pose in poses)
        fixes = [floor.localizer.locate(image, CAMERA) for image in images]
        found = [fix.T_map_base for fix in fixes if isinstance(fix, Fix)]
        number += len(found)
        if len(found) == PLACES:
            line = deviations(found)
            away.append(line[0])
            turned.append(line[1])
            errors += [pose.distance_to(truth) for pose, truth in zip(found, poses, strict=True)]
    heads = 'floor | places found | deviation mm: rms | heading °: rms | error mm: mean'
    table = run.table("The paper's experiment", heads)
    table.add('the paper, a real one', '51 of 51', '0.33', '0.09', '–')
    table.add(
        f'shirube, {lines} rendered lines',
        *(rate(number, lines * PLACES), rms(np.concatenate(away), scale=1e3)),
        *(rms(np.concatenate(turned), scale=math.degrees(1.0)), mean(errors, scale=1e3)),
    )


def main(run: Run, places: int, only: str, lines: int) -> None:
    """Measure the errors."""
    cv2.setNumThreads(1)
    chosen = [condition for condition in CONDITIONS if only in condition.name]
    for survey_error in (0.0, SURVEY_ERROR):
        add_errors(run, SurveyedFloor(survey_error=survey_error), chosen, places)
    add_experiment(run, SurveyedFloor(), lines)


if __name__ == '__main__':
    run_benchmark(
        main,
        places=Option(1000, 20, 'images of a condition'),
        only=Option('', '', 'only the conditions whose name contains this'),
        lines=Option(20, 1, "of the paper's experiment"),
    )
