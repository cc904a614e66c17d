"""Calibration of a lens and of a stereo pair by views of a board, with outlier rejection and standard deviations.

The standard deviations are the larger of those of the least squares fit, which assume independent errors of the
corners, and of the jackknife over views, which also sees errors that the corners of a view share: a warped board, blur.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from typing import TypeVar

import cv2
import numpy as np

from shirube_camera.core.board import Array, BoardView, ShirubeCameraError
from shirube_core.geometry import PinholeCamera

VIEWS_MIN = 5
"""Least number of views of the board."""
PARAMETERS = ('fx', 'fy', 'cx', 'cy', 'k1', 'k2', 'p1', 'p2', 'k3')
_ERROR_MAX = 2.0  # reprojection error beyond which the board's size is wrong [px]
_OUTLIER, _OUTLIER_RATIO = 6.0, 1.5  # robust standard deviations above the median error, and ratio to it
_ROUNDS = 4  # of rejections


@dataclass(frozen=True, eq=False)
class Calibration:
    """A calibrated lens, or a stereo pair; in a pair, each tuple and list has the left camera first.

    Attributes:
        cameras: intrinsics of one or two raw images.
        rotations: R of each, from the optical frame to the rectified one, shape (3, 3).
        projections: P of each, shape (3, 4); a right camera has -fx * baseline at [0, 3].
        parameters: `PARAMETERS` of a lens; baseline of a pair [m].
        sigmas: standard deviations of the parameters.
        residuals: observed minus projected corners of each view [px], for a lens; rows in the rectified left minus
            those in the right image, shape (n, 1), for a pair.
        errors: rms reprojection error of each used view [px].
        tilts: x and y of the normal of the board in the camera's frame for each used view, shape (views, 2).
        used: indices of the views that were not rejected; only these have residuals, errors and tilts.
    """

    cameras: tuple[PinholeCamera, ...]
    rotations: tuple[Array, ...]
    projections: tuple[Array, ...]
    parameters: Array
    sigmas: Array
    residuals: list[Array]
    errors: Array
    tilts: Array
    used: list[int]


Fit = TypeVar('Fit')


def _fit_inliers(fit: Callable[[list[int]], Calibration], views: list[int]) -> Calibration:
    """Fit to the views, then without those whose error is an outlier; add the standard deviations by the jackknife."""
    for _ in range(_ROUNDS):
        if len(views) < VIEWS_MIN:
            raise ShirubeCameraError(
                f'only {len(views)} views can be used; give {VIEWS_MIN} or more, better 20, sharp and with the board '
                'tilted, and check its size (in inner corners)'
            )
        try:
            found = fit(views)
        except cv2.error as fault:
            raise ShirubeCameraError('no lens fits these views; check the size of the board') from fault
        median = float(np.median(found.errors))
        spread = 1.4826 * float(np.median(np.abs(found.errors - median)))
        is_inlier = found.errors <= max(_OUTLIER_RATIO * median, median + _OUTLIER * spread)
        if is_inlier.all():
            break
        views = [view for view, is_good in zip(views, is_inlier, strict=True) if is_good]
    if not median < _ERROR_MAX:
        raise ShirubeCameraError(
            f'the corners do not fit, {median:.1f} px; check size and flatness of the board'
        )
    fits = [fit([view for view in found.used if view != left_out]).parameters for left_out in found.used]
    sigmas = np.sqrt((len(fits) - 1) * np.var(fits, axis=0))
    return replace(found, sigmas=np.maximum(found.sigmas, sigmas))


def calibrate_lens(corners: Array, views: Sequence[BoardView], size: tuple[int, int]) -> Calibration:
    """Calibrate a lens with the distortion model plumb_bob.

    Args:
        corners: corners on the board [m], shape (n, 3).
        views: detected corners of each view.
        size: width and height of the images [px].

    Raises:
        ShirubeCameraError: too few views, or corners that do not fit.
    """

    def fit(used: list[int]) -> Calibration:
        objects, images = ([each.astype(np.float32) for each in part] for part in zip(
            *((corners[views[k].ids], views[k].pixels) for k in used), strict=True
        ))  # fmt: skip
        _, K, D, turns, shifts, sigmas, *_ = cv2.calibrateCameraExtended(objects, images, size, None, None)
        residuals = [
            views[k].pixels - cv2.projectPoints(points, turn, shift, K, D)[0].reshape(-1, 2)
            for k, points, turn, shift in zip(used, objects, turns, shifts, strict=True)
        ]
        errors = np.array([np.sqrt((each**2).sum(axis=1).mean()) for each in residuals])
        tilts = np.array([cv2.Rodrigues(turn)[0][:2, 2] for turn in turns])
        cameras = (_camera(K, D, size),)
        parameters = np.concatenate([K[[0, 1, 0, 1], [0, 1, 2, 2]], D.ravel()[:5]])
        sigmas = sigmas.ravel()[: len(PARAMETERS)]
        P = np.column_stack([K, np.zeros(3)])
        return Calibration(cameras, (np.eye(3),), (P,), parameters, sigmas, residuals, errors, tilts, used)

    return _fit_inliers(fit, [*range(len(views))])


def calibrate_stereo(
    corners: Array, pairs: Sequence[tuple[BoardView, BoardView]], size: tuple[int, int]
) -> tuple[Calibration, Calibration, Calibration]:
    """Calibrate both lenses, then the pair with all parameters together, and rectify it.

    Args:
        corners: corners on the board [m], shape (n, 3).
        pairs: detected corners of each pair of images, left image first.
        size: width and height of the images of both cameras [px].

    Returns:
        calibrations of the pair, of the left lens and of the right lens.

    Raises:
        ShirubeCameraError: too few pairs, corners that do not fit, or cameras that are not side by side.
    """
    matched = [_match(*pair) for pair in pairs]
    lenses = [calibrate_lens(corners, [pair[side] for pair in matched], size) for side in (0, 1)]

    def fit(used: list[int]) -> Calibration:
        objects = [corners[matched[k][0].ids].astype(np.float32) for k in used]
        images = [[matched[k][side].pixels.astype(np.float32) for k in used] for side in (0, 1)]
        start = [
            each for lens in lenses for each in (lens.cameras[0].matrix, np.array(lens.cameras[0].distortion))
        ]
        _, K1, D1, K2, D2, R, T, *_, errors = cv2.stereoCalibrateExtended(
            objects, *images, *start, size, np.eye(3), np.zeros((3, 1)), flags=cv2.CALIB_USE_INTRINSIC_GUESS
        )
        R1, R2, P1, P2, *_ = cv2.stereoRectify(
            K1, D1, K2, D2, size, R, T, flags=cv2.CALIB_ZERO_DISPARITY, alpha=0.0
        )
        if not P2[0, 3] < 0.0:
            raise ShirubeCameraError(
                'the second camera is not on the right of the first; give the left one first'
            )
        (left, right) = (
            [cv2.undistortPoints(each, K, D, R=turn, P=P)[:, 0, 1:] for each in seen]
            for seen, K, D, turn, P in zip(images, (K1, K2), (D1, D2), (R1, R2), (P1, P2), strict=True)
        )
        rows = [a - b for a, b in zip(left, right, strict=True)]
        cameras = _camera(K1, D1, size), _camera(K2, D2, size)
        baseline, rms = np.array([np.linalg.norm(T)]), np.sqrt((errors**2).mean(axis=1))
        return Calibration(
            cameras, (R1, R2), (P1, P2), baseline, 0.0 * baseline, rows, rms, np.zeros((0, 2)), used
        )

    pair = _fit_inliers(fit, sorted({*lenses[0].used} & {*lenses[1].used}))
    return pair, lenses[0], lenses[1]


def _camera(K: Array, D: Array, size: tuple[int, int]) -> PinholeCamera:
    return PinholeCamera(*size, *K[[0, 1, 0, 1], [0, 1, 2, 2]].tolist(), tuple(D.ravel()[:5].tolist()))


def _match(left: BoardView, right: BoardView) -> tuple[BoardView, BoardView]:
    """Return the corners that both images show; one image may have a symmetric board upside down."""
    ids, in_left, in_right = np.intersect1d(left.ids, right.ids, return_indices=True)
    first, second = left.pixels[in_left], right.pixels[in_right]
    is_turned = len(ids) > 0 and (first[-1] - first[0]) @ (second[-1] - second[0]) < 0.0
    return BoardView(ids, first), BoardView(ids, second[::-1] if is_turned else second)
