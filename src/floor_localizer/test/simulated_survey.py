"""A drive in lanes over a random floor with the camera model of `floor_views`, a second implementation."""

import math
from dataclasses import dataclass

import numpy as np
from floor_views import CAMERA, MOUNT, see
from scipy.spatial import cKDTree

from floor_localizer.core.dots import DotMap
from floor_localizer.core.settings import SurveySettings
from floor_localizer.core.survey.array_store import MemoryArrayStore
from floor_localizer.core.survey.floor_survey import SurveyResult, survey_floor
from floor_localizer.core.survey.submap import Submap, build_submap, split_into_submaps
from floor_localizer.core.survey.survey_image import SurveyImage, survey_image, view_outline
from shirube_core.geometry import SE2

SETTINGS = SurveySettings()
OUTLINE = view_outline(CAMERA, MOUNT)
POSITION = np.array(MOUNT.xyz)


@dataclass(frozen=True)
class Drive:
    """A floor, the images of it, and the true poses."""

    floor: DotMap
    images: list[SurveyImage]
    truth: list[SE2]


def lane_poses(size: tuple[float, float], pitch: float = 0.07, step: float = 0.035) -> list[SE2]:
    """Return poses in lanes back and forth; the camera sees nothing beyond the floor."""
    poses = []
    for lane, y in enumerate(np.arange(0.06, size[1] - 0.05, pitch)):
        along = np.arange(0.06, size[0] - 0.05, step)
        heading = 0.0 if lane % 2 == 0 else math.pi
        poses += [SE2(float(x), float(y), heading) for x in (along if lane % 2 == 0 else along[::-1])]
    return [pose @ SE2(*MOUNT.xyz[:2], 0.0).inverse() for pose in poses]


def drive_over(floor: DotMap, truth: list[SE2], seed: int = 0, *, sway=0.0, spurious=0) -> Drive:
    """Return the images of a robot whose odometry is 2 % too long and drifts in yaw at each step."""
    rng = np.random.default_rng(seed)
    odometry, images = SE2(1.0, -2.0, 0.5), []
    for k, pose in enumerate(truth):
        if k:
            step = truth[k - 1].inverse() @ pose
            odometry = odometry @ SE2(1.02 * step.x, 1.02 * step.y, step.yaw + rng.normal(0.0, 0.01))
        swing = sway * np.sin([0.2 * k, 0.3 * k + 1.0, 0.25 * k + 2.0])
        tilt = tuple(0.0175 * swing[1:])
        view = see(floor, pose, rng, noise=0.1, scale=0.02 * swing[0], tilt=tilt, spurious=spurious)
        images.append(survey_image(f'image {k}', odometry, view.dots, CAMERA, MOUNT))
    return Drive(floor, images, truth)


def build_submaps_of(images: list[SurveyImage], settings: SurveySettings = SETTINGS) -> list[Submap]:
    submaps: list[Submap] = []
    for start, last in split_into_submaps([image.T_odom_base for image in images], OUTLINE.width, settings):
        first, is_continuation = start, bool(submaps)
        while True:
            submap = build_submap(images, first, last, POSITION, settings, is_continuation=is_continuation)
            submaps.append(submap)
            if submap.images[-1] >= last:
                break
            first, is_continuation = int(submap.images[-1]) + 1, False
    return submaps


def survey(drive: Drive, existing: DotMap | None = None, settings: SurveySettings = SETTINGS) -> SurveyResult:
    submaps, store = build_submaps_of(drive.images, settings), MemoryArrayStore()
    return survey_floor(drive.images, submaps, OUTLINE, POSITION, settings, store, existing)


def seen_dots(drive: Drive) -> np.ndarray:
    """Return for each dot of the floor whether an image observed it, shape (n,)."""
    tree, seen = cKDTree(drive.floor.points), np.zeros(len(drive.floor), dtype=np.bool_)
    for image, pose in zip(drive.images, drive.truth):
        distance, which = tree.query(pose.transform(image.points))
        seen[which[distance < 0.0005]] = True
    return seen


def errors(drive: Drive, result: SurveyResult) -> np.ndarray:
    """Return the position errors of the images after rigid alignment, shape (k,) [m]."""
    truth = np.array([(drive.truth[k].x, drive.truth[k].y) for k in result.images]) @ (1.0, 1j)
    found = result.states[:, :2] @ (1.0, 1j)
    z, m = found - found.mean(), truth - truth.mean()
    turn = np.vdot(z, m)
    return np.abs(turn / abs(turn) * z - m)
