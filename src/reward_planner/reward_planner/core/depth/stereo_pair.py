"""A rectified stereo pair, horizontal or vertical: its geometry, and its disparities by OpenCV's matchers."""

from __future__ import annotations

from dataclasses import dataclass, replace

import cv2
import numpy as np
from numpy.typing import ArrayLike, NDArray

from reward_planner.core.reward_planner_error import RewardPlannerError
from reward_planner.core.settings import DepthSettings, check_matcher_settings

_TOLERANCE = 0.01  # of calibrated projections [px]
_SMOOTHNESS = (8, 32)  # penalties P1 and P2 for each pixel of a block (Hirschmüller 2008)
_PREFILTER_CAP = 31
_LEFT_RIGHT_TOLERANCE = 1  # tolerance of the left-right check [px]
_BLOCK_BM = 15
_DISPARITY_SCALE = 16.0  # OpenCV's disparities are in 1/16 px
_SPECKLE_STEP = 1.0  # largest difference of neighbouring disparities within a speckle [px]


@dataclass(frozen=True)
class StereoPair:
    """Geometry of the other camera relative to the left one, for whose image the depth is computed.

    Attributes:
        axis: 0 for a horizontal pair (rows are matched), 1 for a vertical pair (columns are matched).
        baseline: position of the other camera along that axis in the left camera's optical frame (x right, y down) [m];
            positive for a camera to the right or below.
        focal_length: focal length along the axis [px].
        offset: principal point of the left camera minus that of the other, along the axis [px].
    """

    axis: int
    baseline: float
    focal_length: float
    offset: float

    @property
    def sign(self) -> int:
        """Sign of the baseline."""
        return 1 if self.baseline > 0.0 else -1

    def mirror(self) -> StereoPair:
        """Return the pair with the other camera on the opposite side."""
        return replace(self, baseline=-self.baseline)

    @property
    def focal_baseline(self) -> float:
        """Depth at a disparity of one pixel, f b [px m]; always positive."""
        return self.focal_length * abs(self.baseline)


def pair_from_projections(P_left: ArrayLike, P_other: ArrayLike) -> StereoPair:
    """Return the stereo pair of two projection matrices P of CameraInfo, shape (3, 4).

    The other camera is at -P[0, 3] / fx along x or at -P[1, 3] / fy along y.

    Raises:
        RewardPlannerError: the cameras are not rectified to each other, or have no baseline.
    """
    left, other = _check_projection(P_left, 'left'), _check_projection(P_other, 'other')
    offset_along_axes = left[:2, 3] - other[:2, 3]
    axis = int(abs(offset_along_axes[1]) > abs(offset_along_axes[0]))
    if offset_along_axes[axis] == 0.0:
        raise RewardPlannerError(
            'P[0, 3] and P[1, 3] of both cameras are equal, there is no baseline; calibrate the pair'
        )
    if abs(offset_along_axes[1 - axis]) > _TOLERANCE * abs(offset_along_axes[axis]):
        raise RewardPlannerError('the cameras are neither a horizontal nor a vertical pair; rectify them as pairs')
    across = abs(left[1 - axis, 2] - other[1 - axis, 2])
    focal = np.abs(left[:2, :2] - other[:2, :2]).max()
    if max(across, focal) > _TOLERANCE:
        raise RewardPlannerError(
            f'focal lengths or shears differ by {focal:.3g} px and principal points across the baseline by '
            f'{across:.3g} px; rectify the cameras as pairs'
        )
    f = float(left[axis, axis])
    return StereoPair(axis, float(offset_along_axes[axis]) / f, f, float(left[axis, 2] - other[axis, 2]))


def _check_projection(P: ArrayLike, name: str) -> NDArray[np.float64]:
    matrix = np.asarray(P, dtype=np.float64)
    if matrix.shape != (3, 4) or not np.isfinite(matrix).all() or matrix[0, 0] <= 0.0 or matrix[1, 1] <= 0.0:
        raise RewardPlannerError(
            f'P of the {name} camera is not a projection matrix; give the 3 x 4 one of its calibration'
        )
    return matrix


class PairMatcher:
    """Matches the images of one pair; those of a vertical pair are transposed."""

    def __init__(self, pair: StereoPair, settings: DepthSettings) -> None:
        """Prepare the matcher; errors are those of `check_matcher_settings`."""
        check_matcher_settings(settings)
        self._pair, self._speckle = pair, settings.speckle
        self._matcher = _make_matcher(settings)

    def match(self, left: NDArray[np.uint8], other: NDArray[np.uint8]) -> NDArray[np.float32]:
        """Return the disparity of each pixel of the left image [px], NaN for none; shapes (height, width).

        Raises:
            RewardPlannerError: images that are not grey or not of the same size.
        """
        for image in (left, other):
            if image.ndim != 2 or image.dtype != np.uint8 or image.shape != left.shape:
                raise RewardPlannerError(
                    f'images are {left.dtype} {left.shape} and {other.dtype} {other.shape}; '
                    'give grey ones of the same size'
                )
        # The matchers want the other camera to the right: images are transposed and mirrored, and the result back.
        raw = self._matcher.compute(self._align_baseline(left), self._align_baseline(other))
        if self._speckle > 0:
            cv2.filterSpeckles(raw, -_DISPARITY_SCALE, self._speckle, _SPECKLE_STEP * _DISPARITY_SCALE)
        along = raw if self._pair.sign > 0 else raw[:, ::-1]
        upright = np.ascontiguousarray(along.T if self._pair.axis == 1 else along)
        disparity = upright.astype(np.float32) / np.float32(_DISPARITY_SCALE)
        missing = disparity < 0.0
        disparity -= np.float32(self._pair.sign * self._pair.offset)
        disparity[missing | (disparity <= 0.0)] = np.nan
        return disparity

    def _align_baseline(self, image: NDArray[np.uint8]) -> NDArray[np.uint8]:
        """Transpose or mirror an image so that the other camera is to the right."""
        along = image.T if self._pair.axis == 1 else image
        return np.ascontiguousarray(along if self._pair.sign > 0 else along[:, ::-1])


def _make_matcher(settings: DepthSettings) -> cv2.StereoMatcher:
    if settings.matcher == 'bm':
        block = max(settings.block, _BLOCK_BM)
        matcher = cv2.StereoBM_create(settings.disparities, block)  # type: ignore[attr-defined]
        matcher.setUniquenessRatio(settings.uniqueness)
        matcher.setDisp12MaxDiff(_LEFT_RIGHT_TOLERANCE)
        return matcher
    area = settings.block**2
    return cv2.StereoSGBM_create(  # type: ignore[attr-defined]
        minDisparity=0,
        numDisparities=settings.disparities,
        blockSize=settings.block,
        P1=_SMOOTHNESS[0] * area,
        P2=_SMOOTHNESS[1] * area,
        disp12MaxDiff=_LEFT_RIGHT_TOLERANCE,
        preFilterCap=_PREFILTER_CAP,
        uniquenessRatio=settings.uniqueness,
        mode=cv2.STEREO_SGBM_MODE_SGBM_3WAY,
    )
