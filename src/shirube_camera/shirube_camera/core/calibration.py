"""Calibration of a lens and of a stereo pair by views of a board, with outlier rejection and standard deviations.

The standard deviations are the larger of those of the least squares fit, which assume independent errors of the
corners, and of the jackknife over views, which also sees errors that the corners of a view share: a warped board, blur.
"""

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from typing import Any, NamedTuple

import cv2
import numpy as np
from numpy.typing import NDArray

from shirube_core.geometry import PinholeCamera
from shirube_core.settings import setting

Array = NDArray[np.float64]

MARKER = 0.75
"""Side of a ChArUco marker, of the dictionary DICT_4X4_1000, relative to that of a square."""
_CORNERS_MIN = 12  # of a partly visible ChArUco board
_WINDOW = 0.25  # half width of the refinement window, relative to the distance of corners
_TERMINATION = (cv2.TERM_CRITERIA_EPS | cv2.TERM_CRITERIA_COUNT, 30, 1e-3)


class ShirubeCameraError(ValueError):
    """A camera, a file or the views of a board do not allow what is asked; the text is one line with the remedy."""


@dataclass(frozen=True)
class BoardSettings:
    """The calibration board; its size is counted in inner corners."""

    pattern: str = setting('chessboard', 'kind of board', choices=('chessboard', 'charuco'))
    columns: int = setting(9, 'inner corners in a row of the board', limits=(3, 30))
    rows: int = setting(6, 'inner corners in a column of the board', limits=(3, 30))
    square: float = setting(0.025, 'side of a square, measured on paper', 'm', (1e-3, 1.0))


class BoardView(NamedTuple):
    """Indices of the detected corners on the board, shape (n,), ascending, and their pixels, shape (n, 2)."""

    ids: NDArray[np.int64]
    pixels: Array


class Board:
    """A calibration board; ``corners`` are its inner corners, row by row [m], shape (n, 3), with z = 0."""

    def __init__(self, settings: BoardSettings) -> None:
        """Prepare the detection; raise a ShirubeCameraError if this OpenCV has no ChArUco."""
        self.size = settings.columns, settings.rows
        x, y = np.meshgrid(*map(np.arange, self.size))
        self.corners = settings.square * np.stack([x.ravel(), y.ravel(), 0 * x.ravel()], axis=-1, dtype=float)
        self._charuco: Any = None
        if settings.pattern == 'charuco':
            aruco: Any = getattr(cv2, 'aruco', None)  # OpenCV 4.6 may lack it
            if not hasattr(aruco, 'CharucoDetector'):
                raise ShirubeCameraError(
                    f'OpenCV {cv2.__version__} has no ChArUco detector; use a chessboard, or OpenCV 4.7 or newer'
                )
            words = aruco.getPredefinedDictionary(aruco.DICT_4X4_1000)
            squares, side = (settings.columns + 1, settings.rows + 1), settings.square
            self._charuco = aruco.CharucoDetector(aruco.CharucoBoard(squares, side, MARKER * side, words))

    def detect(self, image: NDArray[np.uint8]) -> BoardView | None:
        """Return the corners in a grey image, shape (h, w), or None if the board is not found."""
        if self._charuco is not None:
            corners, ids, _, _ = self._charuco.detectBoard(image)
            if ids is None or len(ids) < _CORNERS_MIN:
                return None
            order = np.argsort(ids.ravel())
            return BoardView(ids.ravel()[order], np.asarray(corners, np.float64).reshape(-1, 2)[order])
        is_found, corners = cv2.findChessboardCornersSB(image, self.size, flags=0)
        if not is_found:
            return None
        # The positions of this detector are biased in real images: they made a focal length of 518 px one of 526 px.
        grid = corners.reshape(*self.size[::-1], 2)
        step = min(np.linalg.norm(np.diff(grid, axis=axis), axis=-1).min() for axis in (0, 1))
        half = int(np.clip(_WINDOW * step, 2, 11))
        refined = cv2.cornerSubPix(image, corners.reshape(-1, 1, 2), (half, half), (-1, -1), _TERMINATION)
        return BoardView(np.arange(len(self.corners)), np.asarray(refined, np.float64).reshape(-1, 2))


PARAMETERS = ('fx', 'fy', 'cx', 'cy', 'k1', 'k2', 'p1', 'p2', 'k3')
_VIEWS_MIN, _VIEWS_MAX = 5, 40
_DIFFERENCE_MIN = 0.02  # least distance of a corner of the board in two views, relative to the image's width
_ERROR_MAX = 2.0  # reprojection error beyond which the board's size is wrong [px]
_ROUNDS, _OUTLIER, _OUTLIER_RATIO = 4, 6.0, 1.5  # robust standard deviations above the median, ratio to it
_CORNERS = {'upper left': (0, 0), 'upper right': (1, 0), 'lower left': (0, 1), 'lower right': (1, 1)}
_MARGIN = 0.25  # size of the corners of the image that must be covered, relative to it
_TILT, _TILTED_VIEWS = 0.26, 3  # |sin| of a tilt by 15 degrees; least number of views with it
_FOCAL_SIGMA = 0.004  # relative standard deviation of the focal length that is good enough


@dataclass(frozen=True, eq=False)
class Calibration:
    """A calibrated lens, or a stereo pair, of which tuples have the left camera first.

    Attributes:
        cameras: intrinsics of one or two raw images.
        rotations: R of each, from the optical frame to the rectified one, shape (3, 3).
        projections: P of each, shape (3, 4); a right camera has -fx * baseline at [0, 3].
        parameters: `PARAMETERS` of a lens; baseline of a pair [m].
        sigmas: standard deviations of the parameters.
        residuals: observed minus projected corners of each used view [px], shape (n, 2), of a lens; rows in the
            rectified left minus those in the right image, shape (n, 1), of a pair.
        errors: rms reprojection error of each used view [px].
        tilts: x and y of the board's normal in each used view of a lens, shape (views, 2).
        used: indices of the views that were not rejected.
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


def select_views(corners: Array, views: Sequence[BoardView], width: int) -> list[int]:
    """Return the indices of the views whose boards differ most in the image, which is ``width`` px wide."""
    outer = np.array([[(x, y) for x in corners[[0, -1], 0] for y in corners[[0, -1], 1]]])
    found = [cv2.findHomography(corners[view.ids, :2], view.pixels)[0] for view in views]
    outlines = np.array([cv2.perspectiveTransform(outer, homography) for homography in found]) / width
    distance, chosen = np.full(len(views), np.inf), list[int]()
    while len(chosen) < min(_VIEWS_MAX, len(views)) and distance.max() > _DIFFERENCE_MIN:
        chosen.append(int(distance.argmax()))
        distance = np.minimum(distance, np.abs(outlines - outlines[chosen[-1]]).max(axis=(1, 2, 3)))
    return sorted(chosen)


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
        objects = [corners[views[k].ids].astype(np.float32) for k in used]
        images = [views[k].pixels.astype(np.float32) for k in used]
        _, K, D, turns, shifts, sigmas, *_ = cv2.calibrateCameraExtended(objects, images, size, None, None)
        residuals = [
            pixels - cv2.projectPoints(points, turn, shift, K, D)[0][:, 0]
            for pixels, points, turn, shift in zip(images, objects, turns, shifts, strict=True)
        ]
        errors = np.array([np.sqrt((each**2).sum(axis=1).mean()) for each in residuals])
        tilts = np.array([cv2.Rodrigues(turn)[0][:2, 2] for turn in turns])
        camera, parameters = _camera(K, D, size)
        P, sigmas = np.column_stack([K, np.zeros(3)]), sigmas.ravel()[:9]
        return Calibration((camera,), (np.eye(3),), (P,), parameters, sigmas, residuals, errors, tilts, used)

    return _fit_inliers(fit, [*range(len(views))])


def calibrate_stereo(
    corners: Array, pairs: Sequence[tuple[BoardView, BoardView]], size: tuple[int, int]
) -> tuple[Calibration, Calibration, Calibration]:
    """Calibrate both lenses as `calibrate_lens`, then the pair with all parameters together, and rectify it.

    Returns:
        calibrations of the pair, of the left lens and of the right lens.

    Raises:
        ShirubeCameraError: too few pairs, corners that do not fit, or cameras that are not side by side.
    """
    matched = [_match(*pair) for pair in pairs]
    lenses = [calibrate_lens(corners, [pair[side] for pair in matched], size) for side in (0, 1)]
    start, guess = [lens.cameras[0] for lens in lenses], cv2.CALIB_USE_INTRINSIC_GUESS

    def fit(used: list[int]) -> Calibration:
        objects = [corners[matched[k][0].ids].astype(np.float32) for k in used]
        images = [[matched[k][side].pixels.astype(np.float32) for k in used] for side in (0, 1)]
        (K1, D1), (K2, D2) = ((c.matrix, np.array(c.distortion)) for c in start)
        _, K1, D1, K2, D2, R, T, *_, errors = cv2.stereoCalibrateExtended(
            objects, images[0], images[1], K1, D1, K2, D2, size, np.eye(3), np.zeros((3, 1)), flags=guess
        )
        flags = cv2.CALIB_ZERO_DISPARITY
        R1, R2, P1, P2, *_ = cv2.stereoRectify(K1, D1, K2, D2, size, R, T, flags=flags, alpha=0.0)
        if not P2[0, 3] < 0.0:
            raise ShirubeCameraError('the second camera is not right of the first; give the left one first')
        left = [cv2.undistortPoints(each, K1, D1, R=R1, P=P1)[:, 0, 1:] for each in images[0]]
        right = [cv2.undistortPoints(each, K2, D2, R=R2, P=P2)[:, 0, 1:] for each in images[1]]
        rows = [a - b for a, b in zip(left, right, strict=True)]
        cameras = _camera(K1, D1, size)[0], _camera(K2, D2, size)[0]
        baseline, sigma, rms = np.array([np.linalg.norm(T)]), np.zeros(1), np.sqrt((errors**2).mean(axis=1))
        return Calibration(cameras, (R1, R2), (P1, P2), baseline, sigma, rows, rms, np.empty((0, 2)), used)

    pair = _fit_inliers(fit, sorted({*lenses[0].used} & {*lenses[1].used}))
    return pair, lenses[0], lenses[1]


def _fit_inliers(fit: Callable[[list[int]], Calibration], views: list[int]) -> Calibration:
    """Fit to the views, then without those whose error is an outlier; add the standard deviations by the jackknife."""
    for _ in range(_ROUNDS):
        if len(views) < _VIEWS_MIN:
            raise ShirubeCameraError(f'only {len(views)} views can be used; give 20 sharp ones, check board size')
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
        raise ShirubeCameraError(f'the corners do not fit, {median:.1f} px; check the size of the board')
    fits = [fit([view for view in found.used if view != left_out]).parameters for left_out in found.used]
    return replace(found, sigmas=np.maximum(found.sigmas, np.sqrt((len(fits) - 1) * np.var(fits, axis=0))))


def _camera(K: Array, D: Array, size: tuple[int, int]) -> tuple[PinholeCamera, Array]:
    parameters = np.concatenate([K[[0, 1, 0, 1], [0, 1, 2, 2]], D.ravel()[:5]])
    fx, fy, cx, cy, *distortion = parameters.tolist()
    return PinholeCamera(*size, fx, fy, cx, cy, tuple(distortion)), parameters


def _match(left: BoardView, right: BoardView) -> tuple[BoardView, BoardView]:
    """Return the corners that both images show; one image may have a symmetric board upside down."""
    ids, in_left, in_right = np.intersect1d(left.ids, right.ids, return_indices=True)
    first, second = left.pixels[in_left], right.pixels[in_right]
    is_turned = len(ids) > 0 and (first[-1] - first[0]) @ (second[-1] - second[0]) < 0.0
    return BoardView(ids, first), BoardView(ids, second[::-1] if is_turned else second)


def advice(lens: Calibration, views: Sequence[BoardView]) -> list[str]:
    """Return what the used views of a lens lack, one sentence each; empty if nothing."""
    camera, sentences = lens.cameras[0], []
    places = np.concatenate([views[k].pixels for k in lens.used]) / (camera.width, camera.height)
    for name, place in _CORNERS.items():
        if not (np.abs(places - place).max(axis=1) < _MARGIN).any():
            sentences.append(f'Hold the board into the {name} corner of the image: no view covers it.')
    tilted = (np.abs(lens.tilts) > _TILT).sum(axis=0)
    for axis, count in zip(('sideways', 'up and down'), tilted, strict=True):
        if count < _TILTED_VIEWS:
            sentences.append(f'Turn the board {axis} by 20° to 40°: only {count} views show it so.')
    if (sigma := float((lens.sigmas[:2] / lens.parameters[:2]).max())) > _FOCAL_SIGMA:
        sentences.append(f'Add near and tilted views: the focal length is known to {100.0 * sigma:.1f} %.')
    return sentences
