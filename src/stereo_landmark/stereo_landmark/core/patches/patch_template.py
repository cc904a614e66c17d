"""Template of a planar patch of a taught image, with everything that alignment can precompute."""

from dataclasses import dataclass

import cv2
import numpy as np
from numpy.typing import NDArray

from stereo_landmark.core.arrays import Floats, GreyImage, Masks
from stereo_landmark.core.least_squares import invert_symmetric
from stereo_landmark.core.patches.patch_fit import HOMOGRAPHY_DOF

SPLINE_KERNEL = np.array([1.0, 4.0, 1.0]) / 6.0
"""Cubic B-spline at its knots."""
NOISE_GAIN = float(np.sum(np.convolve(SPLINE_KERNEL, SPLINE_KERNEL) ** 2) ** 2)
"""Variance of a smoothed value for pixels with variance 1."""


def spline_coefficients(image: GreyImage | NDArray[np.float32]) -> NDArray[np.float32]:
    """Return the spline coefficients of an image, shape (h, w)."""
    return _separable_filter(image, SPLINE_KERNEL, SPLINE_KERNEL)


def spline_derivatives(coefficients: NDArray[np.float32]) -> tuple[NDArray[np.float32], ...]:
    """Return the spline, its first and its second derivatives along x and y at the pixels, each of shape (h, w)."""
    slope, bend = np.array([-0.5, 0.0, 0.5]), np.array([1.0, -2.0, 1.0])
    return (
        _separable_filter(coefficients, SPLINE_KERNEL, SPLINE_KERNEL),
        _separable_filter(coefficients, slope, SPLINE_KERNEL),
        _separable_filter(coefficients, SPLINE_KERNEL, slope),
        _separable_filter(coefficients, bend, SPLINE_KERNEL),
        _separable_filter(coefficients, SPLINE_KERNEL, bend),
    )


def smooth_images(images: Floats) -> Floats:
    """Return images, shape (h, w, n), with the smoothing of the spline at the pixels."""
    twice = np.convolve(SPLINE_KERNEL, SPLINE_KERNEL)
    return np.dstack([cv2.sepFilter2D(images[..., k], -1, twice, twice) for k in range(images.shape[2])])


def _separable_filter(image: GreyImage | NDArray[np.float32], along: Floats, down: Floats) -> NDArray[np.float32]:
    return np.asarray(cv2.sepFilter2D(image, cv2.CV_32F, along, down), dtype=np.float32)


MARGIN = 3.0
"""Margin around the outline that belongs to the patch [px]."""
PARAMETERS = HOMOGRAPHY_DOF + 7
"""Parameters: homography, gain, blurred patch, offset, blur along both axes, gain slopes (vignetting)."""
SOFT_SIGMA = 1.5
"""Blur of the soft patch; images from farther away or out of focus are modelled as a mixture with it [px]."""
SLOPE_FRACTION_MIN = 0.2
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

    centre: Floats
    half_size: Floats
    corners: Floats
    coordinates: Floats
    jacobian: Floats
    soft_slope_ratio: float
    inverse: Floats
    noise_factor: float

    @property
    def points(self) -> Floats:
        """Patch coordinates of the measured points, one for each corner, shape (4, 2)."""
        return INSET * self.corners

    @property
    def pixels(self) -> Floats:
        """The measured points in the taught image, shape (4, 2) [px]."""
        return self.centre + self.half_size * self.points


def homography_jacobian(coordinates: Floats) -> Floats:
    """Return the derivatives of patch coordinates by the eight homography parameters, shape (n, 2, 8)."""
    s, t = coordinates.T
    fields = np.zeros((len(coordinates), 2, HOMOGRAPHY_DOF))
    fields[:, 0, :3] = fields[:, 1, 3:6] = np.column_stack([np.ones_like(s), s, t])
    fields[:, 0, 6:] = np.column_stack([s * s, s * t])
    fields[:, 1, 6:] = np.column_stack([s * t, t * t])
    return fields


def patch_template(image: GreyImage, corners: Floats) -> PatchTemplate | None:
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
    value, right, down, *bends = spline_derivatives(spline_coefficients(image[window]))
    softer = cv2.GaussianBlur(image.astype(np.float32), (0, 0), SOFT_SIGMA)[window]
    soft_value, soft_right, soft_down, *_ = spline_derivatives(spline_coefficients(softer))
    selected = _select_pixels(np.hypot(right, down), corners - low)
    if selected is None:
        return None
    centre, half_size = corners.mean(axis=0), 0.5 * np.ptp(corners, axis=0)
    rows, columns = np.nonzero(selected)
    coordinates = (np.column_stack([columns, rows]) + low - centre) / half_size
    slopes = np.column_stack([right[selected], down[selected]]) * half_size
    soft_slopes = np.column_stack([soft_right[selected], soft_down[selected]]) * half_size
    values = value[selected].astype(np.float64)
    motion = np.einsum('nk,nkm->nm', slopes, homography_jacobian(coordinates))
    light = np.column_stack([values, soft_value[selected], np.ones_like(values)])
    bend = np.column_stack([one[selected] for one in bends])
    jacobian = np.column_stack([motion, light, bend, values[:, None] * coordinates])
    inverse = np.empty((PARAMETERS, PARAMETERS))
    if not invert_symmetric(jacobian.T @ jacobian, inverse):
        return None
    noise_factor = _noise_factor(jacobian[:, :HOMOGRAPHY_DOF], selected)
    soft_slope_ratio = float(np.sum(soft_slopes * slopes) / np.sum(slopes**2))
    return PatchTemplate(
        centre,
        half_size,
        (corners - centre) / half_size,
        coordinates,
        jacobian,
        soft_slope_ratio,
        inverse,
        noise_factor,
    )


def _select_pixels(slopes: NDArray[np.float32], corners: Floats) -> Masks | None:
    """Return the mask of the pixels to compare, None if there are too few."""
    inside = np.zeros(slopes.shape, dtype=np.uint8)
    cv2.fillConvexPoly(inside, np.rint(corners).astype(np.int32), 1)
    kernel_size = round(2.0 * MARGIN) + 1
    inside = cv2.dilate(inside, np.ones((kernel_size, kernel_size), dtype=np.uint8))
    inside[:3], inside[-3:], inside[:, :3], inside[:, -3:] = 0, 0, 0, 0
    large = float(np.quantile(slopes[inside > 0], 0.98))
    steep = inside * (slopes > max(SLOPE_FRACTION_MIN * large, SLOPE_MIN))
    # Both sides of a slope are needed to estimate the gain.
    selected = (cv2.dilate(steep, np.ones((3, 3), dtype=np.uint8)) * inside) > 0
    if selected.sum() < PIXELS_MIN:
        return None
    if selected.sum() > PIXELS_MAX:
        rows, columns = np.indices(selected.shape)
        selected &= (rows + columns) % 2 == 0
    if selected.sum() > PIXELS_MAX:
        selected &= slopes >= np.partition(slopes[selected], -PIXELS_MAX)[-PIXELS_MAX]
    return np.asarray(selected)


def _noise_factor(jacobian: Floats, selected: Masks) -> float:
    """Return the motion variance by pixel noise relative to that by independent noise of the smoothed pixels."""
    picture = np.zeros((*selected.shape, jacobian.shape[1]))
    picture[selected] = jacobian
    return float(np.sum(smooth_images(picture) ** 2) / np.sum(jacobian**2))
