"""Type and size check of input images."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from stereo_landmark.core.stereo_landmark_error import StereoLandmarkError

SIDE_MIN = 16
"""Minimum image width and height [px]."""


def check_grey_image(image: NDArray[np.uint8]) -> None:
    """Check that an image is grey, 8 bit and large enough.

    Raises:
        StereoLandmarkError: wrong type, shape or size; one line that names both it and the expected one.
    """
    if not isinstance(image, np.ndarray) or image.dtype != np.uint8:
        kind = f'{image.dtype} values' if isinstance(image, np.ndarray) else type(image).__name__
        raise StereoLandmarkError(f'the image holds {kind}, it must be an array of uint8 (mono8)')
    if image.ndim != 2:
        raise StereoLandmarkError(f'the image has the shape {image.shape}, it must be grey, (h, w) (mono8)')
    if min(image.shape) < SIDE_MIN:
        raise StereoLandmarkError(
            f'the image is {image.shape[1]} x {image.shape[0]} px, each side must be at least {SIDE_MIN} px'
        )
