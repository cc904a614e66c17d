"""Taught on one real stereo pair (EuRoC V1_01), repeated on another, both ways; ORB and SIFT beside it."""

import math
from collections import defaultdict

import cv2
import numpy as np
from _figures import error, rate
from _harness import Option, Run, progress, run_benchmark
from _real_pairs import Moment, RealPairs, load_real_pairs, true_displacement
from _stereo_peers import FeaturePipeline, level_displacement
from _target_choice import TargetChooser
from numpy.typing import NDArray

from shirube_core.geometry import wrap_angle
from stereo_landmark.core.landmark_localizer import LandmarkFix, LandmarkLocalizer
from stereo_landmark.core.procedure.taught_place import TaughtPlace
from stereo_landmark.core.settings import CLOSED_FORM, LandmarkSettings, PlaceSettings

OURS = {
    'targets, roll and pitch given': PlaceSettings(),
    'targets, roll and pitch from the points': PlaceSettings(tilt_sigma=0.5),
    "targets, the paper's closed form": PlaceSettings(method=CLOSED_FORM),
}
WAYS = (('teach', 'repeat'), ('repeat', 'teach'))
Rows = defaultdict[str, list[NDArray[np.float64]]]


def main(run: Run, sets: int) -> None:
    """Teach and repeat both ways."""
    pairs = load_real_pairs(run.data('stereo_euroc'))
    heads = 'way | method | found | position cm: median / max | heading °: median / max'
    table = run.table('Real pairs', heads)
    for begin, end in WAYS:
        for method, rows in _run(pairs, pairs.moments[begin], pairs.moments[end], sets).items():
            errors = np.array(rows)
            cells = (error(column, '.2f', shown=(50, 100)) for column in errors.T)
            found = rate(int(np.isfinite(errors[:, 0]).sum()), sets)
            table.add(f'{begin} to {end}', method, found, *cells)


def _run(pairs: RealPairs, taught: Moment, now: Moment, sets: int) -> Rows:
    """Return the errors of each method, one a set."""
    truth, rows = true_displacement(taught, now), Rows(list)
    chooser = TargetChooser(taught, pairs.rig)
    for seed in progress(range(sets)):
        place = chooser.place(seed)
        for method, settings in OURS.items():
            rows[method].append(_error(_ours(place, now, settings), truth))
        for name in ('ORB', 'SIFT'):
            found = _peer(FeaturePipeline(name, pairs.rig), taught, now, seed)
            rows[f'{name} + stereo + PnP'].append(_error(found, truth))
    return rows


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


def _error(found: NDArray[np.float64] | None, truth: NDArray[np.float64]) -> NDArray[np.float64]:
    """Return the errors of the position [cm], in space, and of the heading [°], shape (2,); NaN without a pose."""
    if found is None:
        return np.full(2, np.nan)
    yaw = math.degrees(abs(wrap_angle(float(found[3] - truth[3]))))
    return np.array([100.0 * np.linalg.norm(found[:3] - truth[:3]), yaw])


if __name__ == '__main__':
    run_benchmark(main, sets=Option(10, 1, 'target sets each way'))
