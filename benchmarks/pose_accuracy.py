"""Poses from rendered images against the truth and against the Cramér-Rao bound. Prints Markdown.

    shirube bench pose_accuracy

The demo's floor (91 582 irregular chips) and camera at places and headings that fill the floor evenly; each image
is located without a prior, and again with one that is 2 mm and 1 degree off, as a tracked robot has it. The map is
exact, so that the noise of the centroids is all there is, or surveyed to 0.05 mm, as the demo's.
"""

from __future__ import annotations

import argparse
import math
import platform
import sys
from collections.abc import Iterator
from dataclasses import dataclass

import cv2
import numpy as np
from _accuracy_report import Outcome, accuracy_table, cause_table
from _actuator_line import actuator_report
from _centroid_noise import dot_noise
from _floor_photographs import CAMERA, Photograph, SurveyedFloor, photographer, tracked_prior, true_mount
from _pose_scores import score_pose
from scipy.spatial import cKDTree
from tqdm import tqdm

from floor_localizer.core.fix import Fix
from scene_simulator.floor.dot_floor import SURVEY_ERROR

RISE, TILT = 0.05, math.radians(2.0)
LINES = 20


@dataclass(frozen=True)
class Condition:
    """How the robot sways.

    Attributes:
        name: name in the table.
        rise: rise of the camera, as a fraction of its height.
        tilt: tilt of the robot, about an axis that rotates from image to image [rad].
    """

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


def photographs(floor: SurveyedFloor, condition: Condition, count: int, seed: int) -> Iterator[Photograph]:
    """Yield the images of a condition."""
    camera = photographer()
    for number, pose in enumerate(floor.places(count)):
        axis = math.tau * number / math.sqrt(5.0)
        sway = (condition.rise, condition.tilt * math.cos(axis), condition.tilt * math.sin(axis))
        rng = np.random.default_rng([seed, number])
        photo = camera.photograph(floor.floor, [pose], true_mount(sway), rng=rng)
        yield Photograph(photo.image, pose, sway)


def outcome(floor: SurveyedFloor, condition: Condition, count: int, seed: int) -> Outcome:
    """Locate all images of a condition."""
    result, camera, tree = Outcome(condition.name), photographer(), cKDTree(floor.floor.points)
    images = photographs(floor, condition, count, seed)
    for number, photograph in enumerate(tqdm(images, condition.name, count, leave=False)):
        dots = floor.localizer.detect(photograph.image)
        fix = floor.localizer.locate_dots(dots, CAMERA)
        result.scores.append(score_pose(fix, photograph.T_map_base))
        prior = tracked_prior(photograph.T_map_base, number)
        tracked = floor.localizer.locate_dots(dots, CAMERA, prior)
        result.tracked.append(score_pose(tracked, photograph.T_map_base))
        if isinstance(fix, Fix) and result.scores[-1].verdict == 'right':
            result.noise.append(dot_noise(floor.floor, tree, camera, photograph, fix, floor.survey_error))
    return result


def main() -> int:
    """Run the benchmark and return its exit code."""
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument('--places', type=int, default=1000, help='images of a condition (default 1000)')
    parser.add_argument('--only', default='', help='only the conditions whose name contains this')
    parser.add_argument('--seed', type=int, default=1, help='of the noise')
    arguments = parser.parse_args()
    cv2.setNumThreads(1)
    chosen = [condition for condition in CONDITIONS if arguments.only in condition.name]
    print(f'Python {platform.python_version()}, numpy {np.__version__}, OpenCV {cv2.__version__}.\n')
    for survey_error in (0.0, SURVEY_ERROR):
        floor = SurveyedFloor(survey_error=survey_error)
        outcomes = [outcome(floor, condition, arguments.places, arguments.seed) for condition in chosen]
        print(f'### Map {"surveyed to 0.05 mm" if survey_error else "exact"}\n')
        print(accuracy_table(outcomes), cause_table(outcomes), sep='\n\n', end='\n\n')
    print(f"### The paper's experiment\n\n{actuator_report(SurveyedFloor(), LINES, arguments.seed)}")
    return 0


if __name__ == '__main__':
    sys.exit(main())
