"""What the method takes for an image."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from stereo_landmark.core.stereo_landmark_error import StereoLandmarkError

SMALLEST_SIDE = 16
"""An image with a side shorter than this shows no landmark [px]."""


def check_grey_image(image: NDArray[np.uint8]) -> None:
    """Refuse what is no grey image.

    Raises:
        StereoLandmarkError: one line that names the type or shape and what is expected.
    """
    if not isinstance(image, np.ndarray) or image.dtype != np.uint8:
        kind = f'{image.dtype} values' if isinstance(image, np.ndarray) else type(image).__name__
        raise StereoLandmarkError(f'the image holds {kind}, it must be an array of uint8 (mono8)')
    if image.ndim != 2:
        raise StereoLandmarkError(f'the image has the shape {image.shape}, it must be grey, (h, w) (mono8)')
    if min(image.shape) < SMALLEST_SIDE:
        raise StereoLandmarkError(
            f'the image is {image.shape[1]} x {image.shape[0]} px, each side must be at least {SMALLEST_SIDE} px'
        )
