"""Template of a planar patch of a taught image, with everything that alignment can precompute."""

from __future__ import annotations

from dataclasses import dataclass

import cv2
import numpy as np
from numpy.typing import NDArray

from stereo_landmark.core.patches.patch_fit import MOTIONS
from stereo_landmark.core.patches.smoothing import coefficients_of, derivatives_of, smoothed
from stereo_landmark.core.symmetric_matrix import invert_symmetric

MARGIN = 3.0
"""Margin around the outline that belongs to the patch [px]."""
COLUMNS = MOTIONS + 7
"""Parameters: homography, gain, blurred patch, offset, blur along both axes, gain slopes (vignetting)."""
SOFT_SIGMA = 1.5
"""Blur of the soft patch; images from farther away or out of focus are modelled as a mixture with it [px]."""
SLOPE_SHARE = 0.2
"""Smallest slope of a selected pixel, as a fraction of the patch's large slopes."""
SLOPE_MIN = 3.0
"""Smallest slope of a selected pixel; slopes below this are noise [grey levels / px]."""
PIXELS_MIN = 150
PIXELS_MAX = 2000
"""Above this every second pixel is used, as smoothed neighbours are redundant, then only the steepest."""
INSET = 0.7
"""Position of the measured points between centre (0) and corner (1), where their errors are nearly independent."""


@dataclass(frozen=True)
class PatchTemplate:
    """A taught patch.

    Patch coordinates start at the mean of the corners; units are half the width (right) and half the height (down).

    Attributes:
        centre: mean of the corners, shape (2,) [px].
        half_size: half width and half height, shape (2,) [px].
        corners: patch coordinates of the corners, shape (4, 2).
        coordinates: patch coordinates of the selected pixels, shape (n, 2).
        jacobian: derivatives of their values by all parameters, shape (n, PARAMETERS).
        soft_slope_ratio: slopes of the blurred patch relative to the slopes of the sharp one.
        inverse: inverse normal matrix of the Jacobian, shape (PARAMETERS, PARAMETERS).
        noise_factor: motion variance by the correlated noise of smoothed pixels, relative to independent noise.
    """

    centre: NDArray[np.float64]
    half: NDArray[np.float64]
    corners: NDArray[np.float64]
    places: NDArray[np.float64]
    columns: NDArray[np.float64]
    softness: float
    inverse: NDArray[np.float64]
    correlation: float

    @property
    def points(self) -> NDArray[np.float64]:
        """Patch coordinates of the measured points, one for each corner, shape (4, 2)."""
        return INSET * self.corners

    @property
    def pixels(self) -> NDArray[np.float64]:
        """The measured points in the taught image, shape (4, 2) [px]."""
        return self.centre + self.half * self.points


def motion_fields(places: NDArray[np.float64]) -> NDArray[np.float64]:
    """Return the derivatives of patch coordinates by the eight homography parameters, shape (n, 2, 8)."""
    s, t = places.T
    fields = np.zeros((len(places), 2, MOTIONS))
    fields[:, 0, :3] = fields[:, 1, 3:6] = np.column_stack([np.ones_like(s), s, t])
    fields[:, 0, 6:] = np.column_stack([s * s, s * t])
    fields[:, 1, 6:] = np.column_stack([s * t, t * t])
    return fields


def patch_template(image: NDArray[np.uint8], corners: NDArray[np.float64]) -> PatchTemplate | None:
    """Create the template of the patch within four corners.

    Args:
        image: taught grey image, shape (h, w).
        corners: corners of a convex quadrilateral, shape (4, 2) [px].

    Returns:
        the template, None if the patch has too little texture or extends beyond the image.
    """
    low = np.floor(corners.min(axis=0) - MARGIN).astype(int) - 3
    high = np.ceil(corners.max(axis=0) + MARGIN).astype(int) + 4
    if (low < 0).any() or (high > image.shape[::-1]).any():
        return None
    window = slice(low[1], high[1]), slice(low[0], high[0])
    value, right, down, *bends = derivatives_of(coefficients_of(image[window]))
    softer = cv2.GaussianBlur(image.astype(np.float32), (0, 0), SOFT_SIGMA)[window]
    soft_value, soft_right, soft_down, *_ = derivatives_of(coefficients_of(softer))
    telling = _telling_pixels(np.hypot(right, down), corners - low)
    if telling is None:
        return None
    centre, half = corners.mean(axis=0), 0.5 * np.ptp(corners, axis=0)
    rows, columns = np.nonzero(telling)
    places = (np.column_stack([columns, rows]) + low - centre) / half
    slopes = np.column_stack([right[telling], down[telling]]) * half
    soft_slopes = np.column_stack([soft_right[telling], soft_down[telling]]) * half
    seen = value[telling].astype(np.float64)
    changes = np.column_stack(
        [
            np.einsum('nk,nkm->nm', slopes, motion_fields(places)),
            *(
                seen,
                soft_value[telling],
                np.ones_like(seen),
                *(bend[telling] for bend in bends),
                seen * places[:, 0],
                seen * places[:, 1],
            ),
        ]
    )
    inverse = np.empty((COLUMNS, COLUMNS))
    if not invert_symmetric(changes.T @ changes, inverse):
        return None
    correlation = _correlation(changes[:, :MOTIONS], telling)
    softness = float(np.sum(soft_slopes * slopes) / np.sum(slopes**2))
    return PatchTemplate(
        centre, half, (corners - centre) / half, places, changes, softness, inverse, correlation
    )


def _telling_pixels(slopes: NDArray[np.float32], corners: NDArray[np.float64]) -> NDArray[np.bool_] | None:
    """Return the mask of the pixels to compare, None if there are too few."""
    inside = np.zeros(slopes.shape, dtype=np.uint8)
    cv2.fillConvexPoly(inside, np.rint(corners).astype(np.int32), 1)
    reach = round(2.0 * MARGIN) + 1
    inside = cv2.dilate(inside, np.ones((reach, reach), dtype=np.uint8))
    inside[:3], inside[-3:], inside[:, :3], inside[:, -3:] = 0, 0, 0, 0
    large = float(np.quantile(slopes[inside > 0], 0.98))
    steep = inside * (slopes > max(SLOPE_SHARE * large, SLOPE_MIN))
    # Both sides of a slope are needed to estimate the gain.
    telling = (cv2.dilate(steep, np.ones((3, 3), dtype=np.uint8)) * inside) > 0
    if telling.sum() < PIXELS_MIN:
        return None
    if telling.sum() > PIXELS_MAX:
        rows, columns = np.indices(telling.shape)
        telling &= (rows + columns) % 2 == 0
    if telling.sum() > PIXELS_MAX:
        telling &= slopes >= np.partition(slopes[telling], -PIXELS_MAX)[-PIXELS_MAX]
    return np.asarray(telling)


def _correlation(changes: NDArray[np.float64], telling: NDArray[np.bool_]) -> float:
    """Return the motion variance by pixel noise relative to that by independent noise of the smoothed pixels."""
    picture = np.zeros((*telling.shape, changes.shape[1]))
    picture[telling] = changes
    return float(np.sum(smoothed(picture) ** 2) / np.sum(changes**2))
