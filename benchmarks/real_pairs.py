"""Taught on one real stereo pair (EuRoC V1_01), repeated on another, both ways; ORB and SIFT beside it."""

import math
from collections import defaultdict

import cv2
import numpy as np
from _figures import error, rate
from _harness import Option, Run, progress, run_benchmark
from _real_pairs import Moment, RealPairs, find_by_features, find_by_targets, load_real_pairs, true_displacement
from _stereo_peers import FeaturePipeline
from _target_choice import TargetChooser
from numpy.typing import NDArray

from shirube_core.geometry import wrap_angle
from stereo_landmark.core.landmark_localizer import LandmarkLocalizer
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
            localizer = LandmarkLocalizer([place], LandmarkSettings(place=settings))
            rows[method].append(_error(find_by_targets(localizer, now)[0], truth))
        for name in ('ORB', 'SIFT'):
            cv2.setRNGSeed(seed)
            pipeline = FeaturePipeline(name, pairs.rig)
            found = find_by_features(taught, pipeline, now, pipeline)
            rows[f'{name} + stereo + PnP'].append(_error(found, truth))
    return rows


def _error(found: NDArray[np.float64], truth: NDArray[np.float64]) -> NDArray[np.float64]:
    """Return the errors of the position [cm], in space, and of the heading [°], shape (2,); NaN without a pose."""
    yaw = math.degrees(abs(wrap_angle(float(found[3] - truth[3]))))
    return np.array([100.0 * np.linalg.norm(found[:3] - truth[:3]), yaw])


if __name__ == '__main__':
    run_benchmark(main, sets=Option(10, 1, 'target sets each way'))
