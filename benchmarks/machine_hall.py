"""Real pairs of a machine hall: taught on one, found on another with its own baseline; SIFT + PnP beside it.

Targets are chosen by the tools. The truth is a bundle adjustment, sure to about 3 mm + 0.5 % in space and 0.05 degrees.
"""

import csv
import json
import math
from dataclasses import replace
from pathlib import Path

import cv2
import numpy as np
from _figures import count, error, mean, rate
from _harness import Option, Run, progress, run_benchmark
from _real_pairs import Moment, find_by_features, find_by_targets
from _stereo_peers import FeaturePipeline
from _target_choice import TargetChooser
from numpy.typing import NDArray

from shirube_core.geometry import CameraMount
from stereo_landmark.core.landmark_localizer import LandmarkLocalizer
from stereo_landmark.core.pair.camera_pair import stereo_rig
from stereo_landmark.core.procedure.taught_place import TaughtPlace
from stereo_landmark.core.settings import BOTH, FEATURES, SHAPES, LandmarkSettings
from stereo_landmark.core.stereo import StereoRig
from stereo_landmark.core.stereo_landmark_error import StereoLandmarkError
from stereo_landmark.files.camera_files import load_camera_calibration, load_grey_image

METHODS = (SHAPES, FEATURES, BOTH)
PEER = 'SIFT + stereo + PnP'
DISTANCE_MIN = 0.1
RIGHT_POSITION, RIGHT_YAW = 0.05, math.radians(1.5)
POINT_SIGMA_MAX, PRIMITIVES = 0.2, 10
TRUTH_CONSTANT, TRUTH_SHARE, TRUTH_YAW = 0.003, 0.005, math.radians(0.05)
Rows = dict[str, list[NDArray[np.float64]]]  # by method: x, y, z and yaw of each pair


class Hall:
    """The pairs, their cameras, and the true displacements of ordered pairs: x, y, z [m] and yaw [rad]."""

    def __init__(self, folder: Path) -> None:
        mount = json.loads((folder / 'mount.json').read_text())
        self.mount = CameraMount(tuple(mount['camera_xyz']), tuple(mount['camera_rpy']))
        self.moments: dict[str, Moment] = {}
        self.rigs: dict[str, StereoRig] = {}
        for row in csv.DictReader((folder / 'poses.csv').open()):
            name, tilt = row['name'], (float(row['roll']), float(row['pitch']))
            left, right = (load_grey_image(folder / name / f'{side}.png') for side in ('left', 'right'))
            self.moments[name] = Moment(left, right, np.zeros(3), (*tilt, 0.0))
            first, second = (load_camera_calibration(folder / name / f'{side}.yaml') for side in ('left', 'right'))
            self.rigs[name] = stereo_rig(first, second, self.mount)
        rows = list(csv.DictReader((folder / 'relative.csv').open()))
        truths = {
            (r['teach'], r['return']): np.array([float(r[f'd{k}']) for k in ('x', 'y', 'z', 'yaw')]) for r in rows
        }
        self.truths = {key: each for key, each in truths.items() if np.linalg.norm(each[:3]) >= DISTANCE_MIN}


def teach(hall: Hall, name: str) -> TaughtPlace | None:
    """Return a place with targets of a pair, None if the tools remark on all sets."""
    chooser = TargetChooser(hall.moments[name], hall.rigs[name], sigma_max=POINT_SIGMA_MAX, primitives=PRIMITIVES)
    try:
        return chooser.place(0)
    except StereoLandmarkError:
        return None


def main(run: Run, step: int) -> None:
    """Teach and return in every ``step``-th ordered pair."""
    hall = Hall(run.data('stereo_machine_hall'))
    keys = list(hall.truths)[::step]
    places = {name: teach(hall, name) for name in progress(dict.fromkeys(begin for begin, _ in keys))}
    pipelines = {name: FeaturePipeline('SIFT', rig) for name, rig in hall.rigs.items()}
    rows: Rows = {name: [] for name in (PEER, *METHODS)}
    variances: Rows = {name: [] for name in METHODS}
    cv2.setRNGSeed(run.seed)
    for begin, end in progress(keys):
        truth, taught = hall.truths[begin, end], hall.moments[begin]
        found = find_by_features(taught, pipelines[begin], hall.moments[end], pipelines[end])
        rows[PEER].append(found - truth)
        place = places[begin]
        if place is None:
            continue
        for method in METHODS:
            # Each pair has a baseline of its own, which differs by more than a recalibration changes it.
            localizer = LandmarkLocalizer([replace(place, rig=hall.rigs[end])], LandmarkSettings(method=method))
            pose, variance = find_by_targets(localizer, hall.moments[end])
            rows[method].append(pose - truth)
            variances[method].append(variance + _truth_variance(truth))
    _add_table(run, rows, variances)
    squares = np.array(rows[BOTH]) ** 2 / [_truth_variance(hall.truths[key]) for key in keys if places[key[0]]]
    bound = ', '.join(f'{each:.2f}' for each in np.nanmean(squares, axis=0))
    run.note(f"NEES of {BOTH} with the truth's covariance alone: {bound}; a stated covariance only lowers it.")


def _truth_variance(truth: NDArray[np.float64]) -> NDArray[np.float64]:
    along = (TRUTH_CONSTANT + TRUTH_SHARE * np.linalg.norm(truth[:3])) ** 2 / 3.0
    return np.array([along, along, along, TRUTH_YAW**2])


def _add_table(run: Run, rows: Rows, variances: Rows) -> None:
    heads = 'method | right | none | wrong | position cm: median / 95 % / max | heading °: the same'
    table = run.table('Machine hall', heads, 'NEES x | y | z | yaw')
    for method, errors in rows.items():
        wrong_by = np.array(errors)
        distance, yaw = np.linalg.norm(wrong_by[:, :3], axis=1), np.abs(wrong_by[:, 3])
        is_found = np.isfinite(distance)
        is_right = is_found & (distance <= RIGHT_POSITION) & (yaw <= RIGHT_YAW)
        squares = wrong_by**2 / np.array(variances[method]) if method in variances else np.full((1, 4), np.nan)
        ratios = [mean(each[np.isfinite(each)], '.2f') if np.isfinite(each).any() else '–' for each in squares.T]
        table.add(
            method,
            rate(int(is_right.sum()), len(errors)),
            count(int((~is_found).sum()), better='lower'),
            count(int((is_found & ~is_right).sum()), better='lower'),
            error(100.0 * distance[is_found], '.2f'),
            error(np.degrees(yaw[is_found]), '.3f'),
            *ratios,
        )


if __name__ == '__main__':
    run_benchmark(main, step=Option(1, 24, 'every so many ordered pairs'))
