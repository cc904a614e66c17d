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
import yaml
from _figures import count, error, mean, rate
from _harness import Option, Run, progress, run_benchmark
from _real_pairs import Moment
from _stereo_peers import FeaturePipeline, level_displacement
from _target_choice import TargetChooser
from numpy.typing import NDArray

from shirube_core.geometry import CameraMount, PinholeCamera
from stereo_landmark.core.landmark_localizer import LandmarkFix, LandmarkLocalizer
from stereo_landmark.core.procedure.taught_place import TaughtPlace
from stereo_landmark.core.settings import BOTH, FEATURES, SHAPES, LandmarkSettings
from stereo_landmark.core.stereo import StereoRig
from stereo_landmark.core.stereo_landmark_error import StereoLandmarkError

METHODS = (SHAPES, FEATURES, BOTH)
PEER = 'SIFT + stereo + PnP'
DISTANCE_MIN = 0.1
RIGHT_POSITION, RIGHT_YAW = 0.05, math.radians(1.5)
POINT_SIGMA_MAX, PRIMITIVES = 0.2, 10
TRUTH_CONSTANT, TRUTH_SHARE, TRUTH_YAW = 0.003, 0.005, math.radians(0.05)


class Hall:
    """The pairs, their cameras, and the true displacements of ordered pairs: x, y, z [m] and yaw [rad]."""

    def __init__(self, folder: Path) -> None:
        mount = json.loads((folder / 'mount.json').read_text())
        self.mount = CameraMount(tuple(mount['camera_xyz']), tuple(mount['camera_rpy']))
        self.moments: dict[str, Moment] = {}
        self.rigs: dict[str, StereoRig] = {}
        for row in csv.DictReader((folder / 'poses.csv').open()):
            name, tilt = row['name'], (float(row['roll']), float(row['pitch']))
            left, right = (
                np.asarray(cv2.imread(str(folder / name / f'{side}.png'), cv2.IMREAD_GRAYSCALE), dtype=np.uint8)
                for side in ('left', 'right')
            )
            self.moments[name] = Moment(left, right, np.zeros(3), (*tilt, 0.0))
            self.rigs[name] = self._rig(folder / name)
        rows = list(csv.DictReader((folder / 'relative.csv').open()))
        truths = {(row['teach'], row['return']): _displacement(row) for row in rows}
        self.truths = {key: each for key, each in truths.items() if np.linalg.norm(each[:3]) >= DISTANCE_MIN}

    def _rig(self, folder: Path) -> StereoRig:
        files = [yaml.safe_load((folder / f'{side}.yaml').read_text()) for side in ('left', 'right')]
        projections = [np.array(each['projection_matrix']['data']).reshape(3, 4) for each in files]
        left, right = (
            PinholeCamera(file['image_width'], file['image_height'], P[0, 0], P[1, 1], P[0, 2], P[1, 2])
            for file, P in zip(files, projections, strict=True)
        )
        return StereoRig(left, right, -projections[1][0, 3] / projections[1][0, 0], self.mount)


def _displacement(row: dict[str, str]) -> NDArray[np.float64]:
    return np.array([float(row[name]) for name in ('dx', 'dy', 'dz', 'dyaw')])


def teach(hall: Hall, name: str) -> TaughtPlace | None:
    """Return a place with targets of a pair, None if the tools remark on all sets."""
    chooser = TargetChooser(hall.moments[name], hall.rigs[name], sigma_max=POINT_SIGMA_MAX, primitives=PRIMITIVES)
    try:
        return chooser.place(0)
    except StereoLandmarkError:
        return None


def locate(place: TaughtPlace, hall: Hall, name: str, method: str) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """Return the displacement found in a pair and its variances, shape (4,) both; NaN without a pose."""
    moment = hall.moments[name]
    # Each pair has a baseline of its own, which differs by more than a recalibration changes it.
    localizer = LandmarkLocalizer([replace(place, rig=hall.rigs[name])], LandmarkSettings(method=method))
    fix = localizer.locate(moment.left, moment.right, moment.tilt)
    if not isinstance(fix, LandmarkFix):
        return np.full(4, np.nan), np.full(4, np.nan)
    pose = fix.displacement.T_place_base
    return np.array([pose.x, pose.y, fix.displacement.height, pose.yaw]), fix.displacement.covariance.diagonal()


def main(run: Run, step: int) -> None:
    """Teach and return in every ``step``-th ordered pair."""
    hall = Hall(run.data('stereo_machine_hall'))
    keys = list(hall.truths)[::step]
    places = {name: teach(hall, name) for name in progress(dict.fromkeys(begin for begin, _ in keys))}
    pipelines = {name: FeaturePipeline('SIFT', rig) for name, rig in hall.rigs.items()}
    rows: dict[str, list[NDArray[np.float64]]] = {name: [] for name in (PEER, *METHODS)}
    variances: dict[str, list[NDArray[np.float64]]] = {name: [] for name in METHODS}
    cv2.setRNGSeed(run.seed)
    for begin, end in progress(keys):
        truth, taught = hall.truths[begin, end], hall.moments[begin]
        known = pipelines[begin].teach((taught.left, taught.right))
        motion = pipelines[end].motion(known, pipelines[end].features(hall.moments[end].left))
        found = None if motion is None else level_displacement(*motion, taught.tilt, hall.rigs[end])
        rows[PEER].append(np.full(4, np.nan) if found is None else found - truth)
        place = places[begin]
        if place is None:
            continue
        for method in METHODS:
            pose, variance = locate(place, hall, end, method)
            rows[method].append(pose - truth)
            variances[method].append(variance + _truth_variance(truth))
    _add_table(run, rows, variances)
    squares = np.array(rows[BOTH]) ** 2 / [_truth_variance(hall.truths[key]) for key in keys if places[key[0]]]
    bound = ', '.join(f'{each:.2f}' for each in np.nanmean(squares, axis=0))
    run.note(f"NEES of {BOTH} with the truth's covariance alone: {bound}; a stated covariance only lowers it.")


def _truth_variance(truth: NDArray[np.float64]) -> NDArray[np.float64]:
    along = (TRUTH_CONSTANT + TRUTH_SHARE * np.linalg.norm(truth[:3])) ** 2 / 3.0
    return np.array([along, along, along, TRUTH_YAW**2])


def _add_table(
    run: Run, rows: dict[str, list[NDArray[np.float64]]], variances: dict[str, list[NDArray[np.float64]]]
) -> None:
    heads = (
        'method | right | none | wrong | position cm: median / 95 % / max | heading °: the same | NEES x | y | z | yaw'
    )
    table = run.table('Machine hall', heads)
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
