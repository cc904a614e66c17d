"""Calibration of three cameras in an L to one another, and their common rectification (2.2.1, figure 1).

Eqs (1) and (2) hold for rectified images: a point is in the same row of the left and the right image and in the same
column of the left and the top one. A rotation common to all cameras aligns the rows with the left-right baseline. The
left-top baseline is then in the image plane, but not quite along the columns, since no L is exactly right-angled. A
shear of all three images, P[0, 1], aligns them: u = f (X + s Y) / Z is the same in left and top if s = -b_x / b_y.
"""

from collections.abc import Sequence
from dataclasses import dataclass

import cv2
import numpy as np
from numpy.typing import NDArray
from scipy.optimize import least_squares
from scipy.spatial.transform import Rotation

from reward_planner.core.reward_planner_error import RewardPlannerError
from shirube_core.geometry import PinholeCamera

VIEWS_MIN = 5
"""Least number of views of the board."""
_RMS_MAX = 1.0  # reprojection error beyond which corners or the size of the board are wrong [px]
_TILT_MAX = 0.25  # baseline across the axis over that along it, beyond which the cameras are not in an L
_EDGE_POINTS = 50  # of each edge of an image, which lens distortion bends

Array = NDArray[np.float64]


@dataclass(frozen=True, eq=False)
class CalibratedCamera:
    """Calibration of one camera of the rig, as in CameraInfo.

    Attributes:
        camera: intrinsics of the raw image, K and D.
        rotation: R from the raw optical frame to the rectified one, shape (3, 3).
        projection: P from the rectified frame of the left camera, shape (3, 4).
    """

    camera: PinholeCamera
    rotation: NDArray[np.float64]
    projection: NDArray[np.float64]

    def rectify_pixels(self, pixels: Array) -> Array:
        """Return where pixels of the raw image, shape (n, 2), are in the rectified one."""
        return _project(self.camera, self.projection[:, :3] @ self.rotation, pixels)


def misalignment(cameras: Sequence[CalibratedCamera], pixels: Sequence[Array]) -> tuple[float, float]:
    """Return the rms row difference of left and right, and column difference of left and top [px].

    Pixels are the same points in the raw images of the three cameras, each of shape (n, 2).
    """
    left, right, top = (camera.rectify_pixels(each) for camera, each in zip(cameras, pixels, strict=True))
    row, column = left[:, 1] - right[:, 1], left[:, 0] - top[:, 0]
    return float(np.sqrt(np.mean(row**2))), float(np.sqrt(np.mean(column**2)))


def calibrate_rig(
    board: Array, views: Sequence[Sequence[Array]], size: tuple[int, int]
) -> tuple[CalibratedCamera, ...]:
    """Calibrate the cameras by views of a flat board that all three see.

    Args:
        board: corners on the board [m], shape (n, 2).
        views: corners of each view in the left, the right and the top image [px], each of shape (n, 2).
        size: width and height of the images [px].

    Raises:
        RewardPlannerError: too few views, corners that do not fit, or cameras that are not in an L.
    """
    if len(views) < VIEWS_MIN:
        raise RewardPlannerError(
            f'{len(views)} views show the board in all three images; take at least {VIEWS_MIN}, better 20'
        )
    corners = np.column_stack([board, np.zeros(len(board))]).astype(np.float32)
    images = [[np.ascontiguousarray(view[k], dtype=np.float32) for view in views] for k in range(3)]
    # Start: each camera by itself, and the other cameras against the left one.
    start = _initial_guess([corners] * len(views), images, size)
    # All of them together, so that an error of the intrinsics does not become one of the rows.
    pixels = np.concatenate(images).reshape(3, -1, 2)
    fit = least_squares(_reprojection_errors, start, method='lm', args=(corners, pixels))
    rms = float(np.sqrt(np.mean(fit.fun**2)))
    if not rms < _RMS_MAX:
        raise RewardPlannerError(
            f'the corners do not fit, rms {rms:.2f} px; check --board, and that images of a view are simultaneous'
        )
    found, poses, _ = _split(fit.x)
    cameras = [
        PinholeCamera(size[0], size[1], fx, fy, cx, cy, (k1, k2, p1, p2, 0.0))
        for fx, fy, cx, cy, k1, k2, p1, p2 in found.tolist()
    ]
    rotations = Rotation.from_rotvec(poses[:, :3]).inv()  # from each camera to the left one
    return rectify_rig(cameras, list(rotations.as_matrix()), list(-rotations.apply(poses[:, 3:])))


def _initial_guess(
    objects: list[NDArray[np.float32]], images: list[list[NDArray[np.float32]]], size: tuple[int, int]
) -> Array:
    """Return the unknowns as `_split` takes them; the intrinsics have two radial coefficients."""
    flags, guess = cv2.CALIB_FIX_K3, None
    found = [cv2.calibrateCamera(objects, seen, size, guess, guess, flags=flags)[1:] for seen in images]
    K, D, turns, shifts = zip(*found, strict=True)
    rig = []
    for k in (1, 2):
        *_, R, t, _, _ = cv2.stereoCalibrate(
            objects, images[0], images[k], K[0], D[0], K[k], D[k], size, flags=cv2.CALIB_FIX_INTRINSIC
        )
        rig.append(np.concatenate([cv2.Rodrigues(R)[0].ravel(), t.ravel()]))
    intrinsics = [(*k[[0, 1, 0, 1], [0, 1, 2, 2]], *d.ravel()[:4]) for k, d in zip(K, D, strict=True)]
    boards = np.hstack([np.reshape(turns[0], (-1, 3)), np.reshape(shifts[0], (-1, 3))])
    return np.concatenate([np.ravel(intrinsics), np.ravel(rig), boards.ravel()])


def _split(unknowns: Array) -> tuple[Array, Array, Array]:
    """Return intrinsics, shape (3, 8), poses of the cameras from the left one, (3, 6), and of the boards, (n, 6)."""
    rig = np.concatenate([np.zeros(6), unknowns[24:36]]).reshape(3, 6)
    return unknowns[:24].reshape(3, 8), rig, unknowns[36:].reshape(-1, 6)


def _reprojection_errors(unknowns: Array, corners: Array, pixels: Array) -> Array:
    """Return the errors of the corners in the images [px]; ``pixels`` have the shape (3, views x n, 2)."""
    intrinsics, rig, boards = _split(unknowns)
    R = Rotation.from_rotvec(boards[:, :3]).as_matrix()
    points = (corners @ R.transpose(0, 2, 1) + boards[:, None, 3:]).reshape(-1, 3)
    errors = []
    for (fx, fy, cx, cy, *distortion), pose, seen in zip(intrinsics, rig, pixels, strict=True):
        K = np.array([[fx, 0.0, cx], [0.0, fy, cy], [0.0, 0.0, 1.0]])
        found = cv2.projectPoints(points, pose[:3], pose[3:], K, np.array(distortion))[0]
        errors.append(found[:, 0] - seen)
    return np.ravel(errors)


def rectify_rig(
    cameras: Sequence[PinholeCamera], rotations: Sequence[Array], centres: Sequence[Array]
) -> tuple[CalibratedCamera, ...]:
    """Rectify the left, the right and the top camera to one another.

    Args:
        cameras: intrinsics of the raw images.
        rotations: matrices from each optical frame to that of the left camera, shape (3, 3).
        centres: positions in the left camera's optical frame [m], shape (3,).

    Raises:
        RewardPlannerError: the cameras are not in an L.
    """
    _, right, top = centres
    across = np.hypot(*right[1:]) / abs(right[0]), np.hypot(top[0], top[2]) / abs(top[1])
    if not max(across) < _TILT_MAX:
        raise RewardPlannerError(
            f'right and top are at {np.round(right, 3).tolist()} and {np.round(top, 3).tolist()} m from the left '
            'camera, not in an L; check the order of the folders'
        )
    # The common frame: x along the left-right baseline, z normal to the plane of the three centres.
    x = right * np.sign(right[0]) / np.linalg.norm(right)
    z = np.cross(x, top * np.sign(top[1]))
    z /= np.linalg.norm(z)
    common = np.array([x, np.cross(z, x), z])
    towards_common = [common @ rotation for rotation in rotations]
    # The shear puts the top camera into the column of the left one; P = K [I | -centre].
    b_x, b_y, _ = common @ top
    shear = np.array([[1.0, -b_x / b_y, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]])
    K = _common_matrix(cameras, [shear @ rotation for rotation in towards_common]) @ shear
    return tuple(
        CalibratedCamera(camera, rotation, np.column_stack([K, -K @ (common @ centre)]))
        for camera, rotation, centre in zip(cameras, towards_common, centres, strict=True)
    )


def _common_matrix(cameras: Sequence[PinholeCamera], transforms: Sequence[Array]) -> Array:
    """Return a camera matrix whose pixels are all within the raw images, after a transform of their rays, (3, 3)."""
    low, high = np.full(2, -np.inf), np.full(2, np.inf)
    last = np.array([cameras[0].width - 1.0, cameras[0].height - 1.0])
    grid = np.stack(np.meshgrid(*(np.linspace(0.0, end, _EDGE_POINTS) for end in last)), axis=-1)
    for camera, transform in zip(cameras, transforms, strict=True):
        x, y = np.moveaxis(_project(camera, transform, grid.reshape(-1, 2)).reshape(grid.shape), -1, 0)
        low = np.maximum(low, (x[:, 0].max(), y[0].max()))
        high = np.minimum(high, (x[:, -1].min(), y[-1].min()))
    if not (low < high).all():
        raise RewardPlannerError('the cameras do not look the same way; turn them parallel')
    f = float((last / (high - low)).max())
    c_x, c_y = 0.5 * (last - f * (low + high))
    return np.array([[f, 0.0, c_x], [0.0, f, c_y], [0.0, 0.0, 1.0]])


def _project(camera: PinholeCamera, matrix: Array, pixels: Array) -> Array:
    """Return pixels of a raw image, shape (n, 2), after a transform of their rays, shape (3, 3)."""
    rays = camera.rays_from_pixels(pixels) @ matrix.T
    return np.asarray(rays[:, :2] / rays[:, 2:])
