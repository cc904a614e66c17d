"""Disparities of one stereo pair, by OpenCV's matchers."""

from __future__ import annotations

import cv2
import numpy as np
from numpy.typing import NDArray

from reward_planner.core.depth.depth_error import DepthError
from reward_planner.core.depth.depth_settings import DepthSettings, check_matcher_settings
from reward_planner.core.depth.stereo_pair import StereoPair

_SMOOTHNESS = (
    8,
    32,
)  # penalties P1 and P2 for each pixel of a block (Hirschmüller 2008)
_PREFILTER_CAP = 31
_LEFT_RIGHT_TOLERANCE = 1  # tolerance of the left-right check [px]
_BLOCK_BM = 15
_DISPARITY_SCALE = 16.0  # OpenCV's disparities are in 1/16 px
_SPECKLE_STEP = 1.0  # largest difference of neighbouring disparities within a speckle [px]


class PairMatcher:
    """Matches the images of one pair; those of a vertical pair are transposed."""

    def __init__(self, pair: StereoPair, settings: DepthSettings) -> None:
        """Prepare the matcher.

        Raises:
            DepthError: OpenCV does not support disparities or block.
        """
        check_matcher_settings(settings)
        self._pair = pair
        self._speckle = settings.speckle
        self._matcher = _make_matcher(settings)

    def match(self, left: NDArray[np.uint8], other: NDArray[np.uint8]) -> NDArray[np.float32]:
        """Return the disparity of each pixel of the left image [px], positive, NaN for none; shape (height, width).

        Args:
            left: rectified grey image of the left camera, shape (height, width).
            other: rectified grey image of the other camera, same shape.

        Raises:
            DepthError: images that are not grey or not of the same size.
        """
        for image in (left, other):
            if image.ndim != 2 or image.dtype != np.uint8 or image.shape != left.shape:
                raise DepthError(
                    f'images are {left.dtype} {left.shape} and {other.dtype} {other.shape}; '
                    'give grey ones of the same size'
                )
        raw = self._matcher.compute(self._align_baseline(left), self._align_baseline(other))
        if self._speckle > 0:
            cv2.filterSpeckles(raw, -_DISPARITY_SCALE, self._speckle, _SPECKLE_STEP * _DISPARITY_SCALE)
        disparity = self._restore_orientation(raw).astype(np.float32) / np.float32(_DISPARITY_SCALE)
        missing = disparity < 0.0
        disparity -= np.float32(self._pair.sign * self._pair.offset)
        disparity[missing | (disparity <= 0.0)] = np.nan
        return disparity

    def _align_baseline(self, image: NDArray[np.uint8]) -> NDArray[np.uint8]:
        """Transpose or mirror an image so that the other camera is to the right."""
        along = image.T if self._pair.axis == 1 else image
        return np.ascontiguousarray(along if self._pair.sign > 0 else along[:, ::-1])

    def _restore_orientation(self, disparity: NDArray[np.int16]) -> NDArray[np.int16]:
        along = disparity if self._pair.sign > 0 else disparity[:, ::-1]
        return np.ascontiguousarray(along.T if self._pair.axis == 1 else along)


def _make_matcher(settings: DepthSettings) -> cv2.StereoMatcher:
    if settings.matcher == 'bm':
        matcher = cv2.StereoBM_create(  # type: ignore[attr-defined]
            settings.disparities, max(settings.block, _BLOCK_BM)
        )
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
