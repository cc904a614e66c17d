"""Alignment of a taught patch with an image: Gauss-Newton on grey values (Lucas & Kanade 1981).

Inverse compositional form of Baker & Matthews (2004): the Jacobian is that of the taught patch, so it is computed once.
Gain, offset, blur and a linear change of gain across the patch are estimated too; Tukey weights reject the pixels that
differ from the taught patch.
"""

from __future__ import annotations

from dataclasses import dataclass

import cv2
import numpy as np

from stereo_landmark.core.arrays import Floats, GreyImage, Ints
from stereo_landmark.core.patches.patch_fit import HOMOGRAPHY_DOF, fit_patch
from stereo_landmark.core.patches.patch_template import (
    NOISE_GAIN,
    PatchTemplate,
    homography_jacobian,
    spline_coefficients,
)

SEARCH_MARGIN = 5
"""Margin of the image window around the predicted patch [px]."""
MODEL_SIGMA = 0.004
"""Standard deviation of a point by model errors other than noise [px]."""

STRAIN_MAX = 1.6
"""Largest strain, in variances of the noise; a patch whose cells move apart by more is not the taught plane."""


@dataclass(frozen=True)
class AlignedPatch:
    """A patch aligned with another image.

    Attributes:
        points: measured points of the patch, shape (4, 2) [px].
        covariance: covariance of the points by the noise of this image, shape (8, 8) [px²].
        taught_covariance: covariance of the points by the noise of the taught image, in its pixels, shape (8, 8) [px²].
        corners: corners of the patch, shape (4, 2) [px].
    """

    points: Floats
    covariance: Floats
    taught_covariance: Floats
    corners: Floats


def align_patch(template: PatchTemplate, image: GreyImage, start: Floats) -> AlignedPatch | None:
    """Align a patch with an image.

    Args:
        template: taught patch.
        image: grey image, shape (h, w).
        start: predicted corners, off by about a pixel at most, shape (4, 2) [px].

    Returns:
        the aligned patch, None if the image does not show it there or a large part of it is occluded.
    """
    low = np.maximum(np.floor(start.min(axis=0)).astype(int) - SEARCH_MARGIN - 3, 0)
    high = np.ceil(start.max(axis=0)).astype(int) + SEARCH_MARGIN + 4
    window = image[low[1] : high[1], low[0] : high[0]]
    if min(window.shape) < 3 * SEARCH_MARGIN:
        return None
    homography = cv2.getPerspectiveTransform(
        template.corners.astype(np.float32), (start - low).astype(np.float32)
    )
    inverse = template.inverse.copy()
    scale = float(template.half_size.max())
    residual_variance, gain, strain = fit_patch(
        spline_coefficients(window),
        template.coordinates,
        template.jacobian,
        template.soft_slope_ratio,
        scale,
        homography,
        inverse,
    )
    if not residual_variance >= 0.0 or strain * NOISE_GAIN / template.noise_factor > STRAIN_MAX:
        return None
    return _aligned_patch(
        template, homography, low, inverse[:HOMOGRAPHY_DOF, :HOMOGRAPHY_DOF] / gain**2, residual_variance
    )


def _aligned_patch(
    template: PatchTemplate, homography: Floats, low: Ints, inverse: Floats, residual_variance: float
) -> AlignedPatch:
    """Return the points with their covariances; half of the noise is attributed to each image."""
    pixels, jacobians = _project(homography, template.points)
    fields = homography_jacobian(template.points)
    (_, (middle,)) = _project(homography, np.zeros((1, 2)))
    area_ratio = abs(float(np.linalg.det(middle))) / float(np.prod(template.half_size))
    noise = 0.5 * residual_variance / NOISE_GAIN * template.noise_factor
    image_jacobian = (jacobians @ fields).reshape(HOMOGRAPHY_DOF, HOMOGRAPHY_DOF)
    taught_jacobian = (template.half_size[:, None] * fields).reshape(HOMOGRAPHY_DOF, HOMOGRAPHY_DOF)
    model = MODEL_SIGMA**2 * np.eye(HOMOGRAPHY_DOF)
    return AlignedPatch(
        pixels + low,
        noise / area_ratio * image_jacobian @ inverse @ image_jacobian.T + model,
        noise * taught_jacobian @ inverse @ taught_jacobian.T + model,
        _project(homography, template.corners)[0] + low,
    )


def _project(homography: Floats, coordinates: Floats) -> tuple[Floats, Floats]:
    """Return the projections of patch coordinates, shape (n, 2), and their Jacobians, shape (n, 2, 2)."""
    projected = coordinates @ homography[:, :2].T + homography[:, 2]
    pixels = projected[:, :2] / projected[:, 2:]
    by_coordinates = homography[None, :2, :2] - pixels[:, :, None] * homography[None, 2:, :2]
    return pixels, by_coordinates / projected[:, 2, None, None]
