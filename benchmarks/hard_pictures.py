"""Hard pictures, rendered: how many are located right, not at all, or wrong. Prints Markdown.

    shirube bench hard_pictures --pictures out/hard_pictures

Each picture is located without a prior and again with one that is 2 mm and 1 degree off, as a tracked robot has it,
on the surveyed map of the demo's floor (or of one with fewer, larger or paler chips). Right is within 2 mm and 1.5
degrees, exact within 0.5 mm.
"""

from __future__ import annotations

import argparse
import platform
import sys
from pathlib import Path

import cv2
import numpy as np
from _floor_photographs import CAMERA, SurveyedFloor, tracked_prior
from _hard_conditions import CONDITIONS, HardCondition
from _hard_report import HardOutcome, hard_table
from _image_grid import annotated_image, image_grid, write_image
from _pose_scores import score_pose
from tqdm import tqdm

from scene_simulator.floor.dot_floor import FloorDesign


def hard_outcome(floor: SurveyedFloor, condition: HardCondition, count: int, seed: int) -> HardOutcome:
    """Locate pictures of one condition at places all over a floor of its design."""
    result = HardOutcome(condition.name)
    for number, pose in enumerate(tqdm(floor.places(count), condition.name, count, leave=False)):
        photograph = condition.photograph(floor.floor, pose, np.random.default_rng([seed, number]))
        dots = floor.localizer.detect(photograph.image)
        found = floor.localizer.locate_dots(dots, CAMERA)
        tracked = floor.localizer.locate_dots(dots, CAMERA, tracked_prior(pose, number))
        result.scores.append(score_pose(found, pose))
        result.tracked.append(score_pose(tracked, pose))
        if number == 0:
            result.example = annotated_image(photograph.image, found, condition.name)
    return result


def main() -> int:
    """Run the benchmark and return its exit code."""
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument('--places', type=int, default=300, help='pictures of a condition (default 300)')
    parser.add_argument('--only', default='', help='only the conditions whose name contains this')
    parser.add_argument('--seed', type=int, default=1, help='of noise and disturbances')
    parser.add_argument('--pictures', type=Path, help='folder for the first picture of each condition')
    arguments = parser.parse_args()
    cv2.setNumThreads(1)
    floors: dict[FloorDesign, SurveyedFloor] = {}
    outcomes = []
    for condition in CONDITIONS:
        if arguments.only in condition.name:
            floor = floors.setdefault(condition.design, SurveyedFloor(condition.design))
            outcomes.append(hard_outcome(floor, condition, arguments.places, arguments.seed))
    print(f'Python {platform.python_version()}, numpy {np.__version__}, OpenCV {cv2.__version__}.\n')
    print(hard_table(outcomes))
    if arguments.pictures:
        for outcome in outcomes:
            write_image(arguments.pictures / f'{outcome.name.replace(" ", "_")}.png', outcome.example)
        grid = image_grid([outcome.example for outcome in outcomes])
        write_image(arguments.pictures / 'hard_pictures.png', grid)
    return 0


if __name__ == '__main__':
    sys.exit(main())
