"""The two pairs of EuRoC's room V1_01, rectified and levelled by the truth, one taught and the other come back to."""

from __future__ import annotations

import json
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import cv2
import numpy as np
from numpy.typing import NDArray
from scipy.spatial.transform import Rotation

from shirube_geometry import CameraMount, PinholeCamera
from stereo_landmark.core.edges.settings import EdgeSettings
from stereo_landmark.core.place.stereo_rig import StereoRig
from stereo_landmark.core.procedure.detected_scene import ImageProcessing, detect_scene
from stereo_landmark.core.procedure.primitive import Kind, Primitive, size_of
from stereo_landmark.core.procedure.stereo_view import StereoView
from stereo_landmark.core.procedure.taught_place import TaughtPlace
from stereo_landmark.core.procedure.teaching import TargetChoice, Teacher
from stereo_landmark.core.stereo_landmark_error import StereoLandmarkError

BASE_AXES = np.array([[0.0, 0.0, 1.0], [0.0, -1.0, 0.0], [1.0, 0.0, 0.0]])
"""``R_base_body``: the drone's body has x up and z ahead."""

THRESHOLD = 3.31
"""With which each photograph has nearly 1000 segments [grey levels / px]."""
SIZE_MIN, APART = 14.0, 30.0
"""Of the quadrilaterals that are taught [px]."""


@dataclass(frozen=True)
class PhotographedPair:
    """A pair of photographs.

    Attributes:
        images: left and right, rectified, each of shape (480, 752).
        tilt: roll and pitch of the base [rad].
        T_world_level: the level base frame under the tilt, shape (4, 4).
    """

    images: tuple[NDArray[np.uint8], NDArray[np.uint8]]
    tilt: tuple[float, float]
    T_world_level: NDArray[np.float64]


def load_photographs(folder: Path) -> tuple[StereoRig, dict[str, PhotographedPair]]:
    """Return the rectified cameras, and the pairs by their role: teach and repeat.

    Args:
        folder: ``stereo_euroc``.
    """
    truth = json.loads((folder / 'calibration_and_truth.json').read_text())
    matrices, lenses = zip(*(_lens(truth[f'cam{i}']) for i in (0, 1)), strict=True)
    T_body = [np.array(truth[f'T_BS_cam{i}']) for i in (0, 1)]
    T = np.linalg.inv(T_body[1]) @ T_body[0]
    size = (truth['cam0']['width'], truth['cam0']['height'])
    R_left, R_right, P_left, P_right, *_ = cv2.stereoRectify(
        matrices[0],
        lenses[0],
        matrices[1],
        lenses[1],
        size,
        T[:3, :3],
        T[:3, 3:],
        flags=cv2.CALIB_ZERO_DISPARITY,
        alpha=0.0,
    )
    maps = [
        cv2.initUndistortRectifyMap(K, d, R, P[:, :3], size, cv2.CV_32FC1)
        for K, d, R, P in zip(matrices, lenses, (R_left, R_right), (P_left, P_right), strict=True)
    ]
    R_base_camera = BASE_AXES @ T_body[0][:3, :3] @ R_left.T
    rpy = Rotation.from_matrix(R_base_camera).as_euler('xyz')
    mount = CameraMount(tuple((BASE_AXES @ T_body[0][:3, 3]).tolist()), tuple(rpy.tolist()))
    rig = StereoRig(
        _camera(P_left, size), _camera(P_right, size), float(-P_right[0, 3] / P_right[0, 0]), mount
    )
    return rig, {frame['role']: _pair(frame, folder, maps) for frame in truth['frames']}


def teach_photographs(rig: StereoRig, pair: PhotographedPair, count: int, seed: int) -> TaughtPlace:
    """Teach quadrilaterals, chosen at random, that lie apart and can be measured, as one target.

    Args:
        rig: the cameras.
        pair: the one to teach.
        count: of the quadrilaterals at most.
        seed: of the choice.
    """
    processing = ImageProcessing(edges=EdgeSettings(threshold=THRESHOLD))
    left, right = (detect_scene(image, processing) for image in pair.images)
    view = StereoView(left, right, rig, pair.tilt)
    teacher = Teacher(view, processing)
    parts: dict[str, Primitive] = {}
    found = view.left.kinds[Kind.QUADRILATERAL].primitives
    for number in np.random.default_rng(seed).permutation(len(found)).tolist():
        apart = [np.hypot(*(found[number].centre - other.centre)) for other in parts.values()]
        if len(parts) < count and size_of(found[number]) >= SIZE_MIN and min(apart, default=np.inf) >= APART:
            try:
                teacher.measure(found[number])
            except StereoLandmarkError:
                continue
            parts[f'part {number}'] = found[number]
    return teacher.teach('room', [TargetChoice('target', parts)])


def _lens(entry: dict[str, Any]) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    fx, fy, cx, cy = entry['intrinsics_fx_fy_cx_cy']
    lens = np.array([*entry['distortion_k1_k2_p1_p2'], 0.0])
    return np.array([[fx, 0.0, cx], [0.0, fy, cy], [0.0, 0.0, 1.0]]), lens


def _camera(P: NDArray[np.float64], size: tuple[int, int]) -> PinholeCamera:
    fx, fy, cx, cy = P[0, 0], P[1, 1], P[0, 2], P[1, 2]
    return PinholeCamera(*size, float(fx), float(fy), float(cx), float(cy))


def _pair(frame: dict[str, Any], folder: Path, maps: list[Any]) -> PhotographedPair:
    images = []
    for side, (u, v) in zip(('left', 'right'), maps, strict=True):
        raw: Any = cv2.imread(str(folder / f'{frame["t"]}_{side}.png'), cv2.IMREAD_GRAYSCALE)
        rectified = cv2.remap(raw, u, v, cv2.INTER_CUBIC, borderMode=cv2.BORDER_REPLICATE)
        images.append(np.asarray(rectified, dtype=np.uint8))
    R_world_base = Rotation.from_quat(np.roll(frame['q_wxyz'], -1)).as_matrix() @ BASE_AXES.T
    roll, pitch, yaw = Rotation.from_matrix(R_world_base).as_euler('xyz').tolist()
    T = np.eye(4)
    T[:3, :3], T[:3, 3] = Rotation.from_euler('z', yaw).as_matrix(), frame['p']
    return PhotographedPair((images[0], images[1]), (roll, pitch), T)
