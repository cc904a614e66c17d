"""Hard pictures, rendered: how many are located right, not at all, or wrong.

    shirube bench hard_pictures --pictures out/hard_pictures

Each picture is located without a prior and again with one that is 2 mm and 1 degree off, as a tracked robot has it,
on the surveyed map of the demo's floor (or of one with fewer, larger or paler chips). Right is within 2 mm and 1.5
degrees, exact within 0.5 mm.
"""

from collections import Counter
from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path

import cv2
import numpy as np
from _figures import rate, rms
from _floor_photographs import CAMERA, Outcome, SurveyedFloor
from _hard_conditions import CONDITIONS, HardCondition
from _harness import Option, Run, progress, run_benchmark
from _pose_scores import EXACT_WITHIN, pose_cells, whitened_errors
from numpy.typing import NDArray

from floor_localizer.core.fix import Fix, NoFix
from floor_localizer.localization.visualization import debug_picture
from scene_simulator.floor.dot_floor import FloorDesign
from shirube_core.geometry import SE2

ZOOM, STRIP, COLUMNS = 1.25, 26, 4


def hard_outcome(floor: SurveyedFloor, condition: HardCondition, count: int, seed: int) -> Outcome:
    """Locate pictures of one condition at places all over a floor of its design."""
    poses = enumerate(progress(floor.places(count), condition.name, count))
    return floor.outcome((picture(floor, condition, pose, [seed, number]), pose) for number, pose in poses)


def picture(floor: SurveyedFloor, condition: HardCondition, pose: SE2, seed: list[int]) -> NDArray[np.uint8]:
    """Return a picture of a condition."""
    return condition.photograph(floor.floor, pose, np.random.default_rng(seed)).image


def first_picture(floor: SurveyedFloor, condition: HardCondition, seed: int) -> NDArray[np.uint8]:
    """Return the first picture of a condition with its dots."""
    image = picture(floor, condition, next(floor.places(1)), [seed, 0])
    return annotated_image(image, floor.localizer.locate(image, CAMERA), condition.name)


def annotated_image(image: NDArray[np.uint8], result: Fix | NoFix, label: str) -> NDArray[np.uint8]:
    """Return an enlarged image under its label, with its dots: found on the map green, others red."""
    large = cv2.resize(image, None, fx=ZOOM, fy=ZOOM, interpolation=cv2.INTER_CUBIC)
    if result.dots is not None:
        pixels = (result.dots.pixels + 0.5) * ZOOM - 0.5
        dots = replace(result.dots, pixels=pixels, diameters=result.dots.diameters * ZOOM)
        result = replace(result, dots=dots)
    marked = debug_picture(np.asarray(large, dtype=np.uint8), result)
    strip = np.full((STRIP, marked.shape[1], 3), 255, dtype=np.uint8)
    cv2.putText(strip, label, (4, STRIP - 8), cv2.FONT_HERSHEY_SIMPLEX, 0.5, (20, 20, 20), 1, cv2.LINE_AA)
    return np.pad(np.vstack([strip, marked]), ((3, 3), (3, 3), (0, 0)), constant_values=255)


def write_pictures(folder: Path, pictures: Sequence[NDArray[np.uint8]]) -> None:
    """Write the first pictures side by side."""
    blank = np.full_like(pictures[0], 255)
    padded = [*pictures, *[blank] * (-len(pictures) % COLUMNS)]
    rows = [np.hstack(padded[k : k + COLUMNS]) for k in range(0, len(padded), COLUMNS)]
    folder.mkdir(parents=True, exist_ok=True)
    cv2.imwrite(str(folder / 'hard_pictures.png'), np.vstack(rows), [cv2.IMWRITE_PNG_COMPRESSION, 9])


def main(run: Run, places: int, only: str, pictures: str) -> None:
    """Locate the pictures of all conditions."""
    cv2.setNumThreads(1)
    heads = 'condition | prior | right / none / wrong | exact | error mm: median / 95 % | ° | error / stated'
    table = run.table('Hard pictures', heads, 'why none')
    floors: dict[FloorDesign, SurveyedFloor] = {}
    chosen = [condition for condition in CONDITIONS if only in condition.name]
    for condition in chosen:
        floor = floors.setdefault(condition.design, SurveyedFloor(condition.design))
        outcome = hard_outcome(floor, condition, places, run.seed)
        for prior, scores in (('none', outcome.scores), ('tracked', outcome.tracked)):
            exact = rate(sum(score.distance < EXACT_WITHIN for score in scores), len(scores))
            verdicts, position, heading = pose_cells(scores)
            reasons = Counter(score.reason for score in scores if score.reason)
            why = ', '.join(f'{number} x {reason}' for reason, number in reasons.most_common())
            consistency = rms(whitened_errors(scores), '.2f', better='one')
            table.add(condition.name, prior, verdicts, exact, position, heading, consistency, why)
    if pictures:
        examples = [first_picture(floors[each.design], each, run.seed) for each in chosen]
        write_pictures(Path(pictures), examples)


if __name__ == '__main__':
    run_benchmark(
        main,
        places=Option(300, 10, 'pictures of a condition'),
        only=Option('', '', 'only the conditions whose name contains this'),
        pictures=Option('', '', 'folder for the first picture of each condition'),
    )
