"""Taught on one real stereo pair, repeated on another: `./shirube bench real_pairs`.

Prints the markdown of the section "Real images" of stereo_landmark.md. The photographs are those of ``stereo_euroc/``
(EuRoC V1_01) in the folder that SHIRUBE_DATA names.
"""

from __future__ import annotations

import argparse
import math
import os
import sys
from collections import defaultdict
from pathlib import Path

import cv2
import numpy as np
from _real_pairs import Moment, RealPairs, load_real_pairs, true_displacement
from _stereo_peers import FeaturePipeline, level_displacement
from _target_choice import TargetChooser
from numpy.typing import NDArray
from tqdm import tqdm

from shirube_core.geometry import wrap_angle
from stereo_landmark.core.landmark_fix import LandmarkFix
from stereo_landmark.core.landmark_localizer import LandmarkLocalizer
from stereo_landmark.core.procedure.taught_place import TaughtPlace
from stereo_landmark.core.settings import CLOSED_FORM, LandmarkSettings, PlaceSettings

OURS = {
    'targets, roll and pitch given': PlaceSettings(),
    'targets, roll and pitch from the points': PlaceSettings(tilt_sigma=0.5),
    "targets, the paper's closed form": PlaceSettings(method=CLOSED_FORM),
}
WAYS = (('teach', 'repeat'), ('repeat', 'teach'))
Rows = dict[str, list[NDArray[np.float64] | None]]


def main() -> int:
    """Print the tables."""
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument('--sets', type=int, default=10, help='target sets each way (default: 10)')
    options = parser.parse_args()
    folder = Path(os.environ.get('SHIRUBE_DATA', '')) / 'stereo_euroc'
    if not folder.is_dir():
        print('set SHIRUBE_DATA to the folder with stereo_euroc', file=sys.stderr)
        return 1
    pairs = load_real_pairs(folder)
    print(_head())
    for begin, end in WAYS:
        rows, drawn = _run(pairs, pairs.moments[begin], pairs.moments[end], options.sets)
        for method, errors in rows.items():
            print(_row(f'{begin} to {end}', method, errors))
        print(f'<!-- sets drawn: {drawn} -->', file=sys.stderr)
    return 0


def _run(pairs: RealPairs, taught: Moment, now: Moment, sets: int) -> tuple[Rows, list[int]]:
    """Return the errors of each method, a row a set, and how many sets were drawn for each."""
    truth, rows, drawn = true_displacement(taught, now), defaultdict(list), []
    chooser = TargetChooser(taught, pairs.rig)
    for seed in tqdm(range(sets), leave=False):
        place, draws = chooser.place(seed)
        drawn.append(draws)
        for method, settings in OURS.items():
            rows[method].append(_error(_ours(place, now, settings), truth))
        for name in ('ORB', 'SIFT'):
            found = _peer(FeaturePipeline(name, pairs.rig), taught, now, seed)
            rows[f'{name} + stereo + PnP'].append(_error(found, truth))
    return rows, drawn


def _peer(pipeline: FeaturePipeline, taught: Moment, now: Moment, seed: int) -> NDArray[np.float64] | None:
    cv2.setRNGSeed(seed)
    known = pipeline.teach((taught.left, taught.right))
    motion = pipeline.motion(known, pipeline.features(now.left))
    return None if motion is None else level_displacement(*motion, taught.tilt, pipeline.rig)


def _ours(place: TaughtPlace, now: Moment, settings: PlaceSettings) -> NDArray[np.float64] | None:
    localizer = LandmarkLocalizer([place], LandmarkSettings(place=settings))
    answer = localizer.locate(now.left, now.right, now.tilt)
    if not isinstance(answer, LandmarkFix):
        return None
    pose = answer.displacement.T_place_base
    return np.array([pose.x, pose.y, answer.displacement.height, pose.yaw])


def _error(found: NDArray[np.float64] | None, truth: NDArray[np.float64]) -> NDArray[np.float64] | None:
    """Return the errors of the position [cm], in space, and of the heading [°], shape (2,)."""
    if found is None:
        return None
    yaw = math.degrees(abs(wrap_angle(float(found[3] - truth[3]))))
    return np.array([100.0 * np.linalg.norm(found[:3] - truth[:3]), yaw])


def _head() -> str:
    return (
        '| way | method | found | position cm: median / max | heading °: median / max | position of each set cm |\n'
        '|---|---|---|---|---|---|'
    )


def _row(way: str, method: str, errors: list[NDArray[np.float64] | None]) -> str:
    there = np.array([error for error in errors if error is not None]).reshape(-1, 2)
    each = ', '.join('none' if error is None else f'{error[0]:.1f}' for error in errors)
    if not len(there):
        return f'| {way} | {method} | 0/{len(errors)} | - | - | {each} |'
    (cm, degrees), (cm_max, degrees_max) = np.median(there, axis=0), there.max(axis=0)
    return (
        f'| {way} | {method} | {len(there)}/{len(errors)} | {cm:.2f} / {cm_max:.2f} | '
        f'{degrees:.2f} / {degrees_max:.2f} | {each} |'
    )


if __name__ == '__main__':
    sys.exit(main())
