"""Alignment of a taught patch with an image: Gauss-Newton on grey values (Lucas & Kanade 1981).

Inverse compositional form of Baker & Matthews (2004): the Jacobian is that of the taught patch, so it is computed once.
Gain, offset, blur and a linear change of gain across the patch are estimated too; Tukey weights reject the pixels that
differ from the taught patch.
"""

from __future__ import annotations

from dataclasses import dataclass

import cv2
import numpy as np
from numpy.typing import NDArray

from stereo_landmark.core.patches.patch_fit import MOTIONS, fit_patch
from stereo_landmark.core.patches.patch_template import PatchTemplate, motion_fields
from stereo_landmark.core.patches.smoothing import NOISE, coefficients_of

SLACK = 5
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

    points: NDArray[np.float64]
    covariance: NDArray[np.float64]
    taught_covariance: NDArray[np.float64]
    corners: NDArray[np.float64]


def align_patch(
    template: PatchTemplate, image: NDArray[np.uint8], start: NDArray[np.float64]
) -> AlignedPatch | None:
    """Align a patch with an image.

    Args:
        template: taught patch.
        image: grey image, shape (h, w).
        start: predicted corners, off by about a pixel at most, shape (4, 2) [px].

    Returns:
        the aligned patch, None if the image does not show it there or a large part of it is occluded.
    """
    low = np.maximum(np.floor(start.min(axis=0)).astype(int) - SLACK - 3, 0)
    high = np.ceil(start.max(axis=0)).astype(int) + SLACK + 4
    part = image[low[1] : high[1], low[0] : high[0]]
    if min(part.shape) < 3 * SLACK:
        return None
    homography = cv2.getPerspectiveTransform(
        template.corners.astype(np.float32), (start - low).astype(np.float32)
    )
    inverse = template.inverse.copy()
    scale = float(template.half.max())
    rest, gain, strain = fit_patch(
        coefficients_of(part),
        template.places,
        template.columns,
        template.softness,
        scale,
        homography,
        inverse,
    )
    if not rest >= 0.0 or strain * NOISE / template.correlation > STRAIN_MAX:
        return None
    return _measured(template, homography, low, inverse[:MOTIONS, :MOTIONS] / gain**2, rest)


def _measured(
    template: PatchTemplate,
    homography: NDArray[np.float64],
    low: NDArray[np.int64],
    inverse: NDArray[np.float64],
    rest: float,
) -> AlignedPatch:
    """Return the points with their covariances; half of the noise is attributed to each image."""
    pixels, jacobians = _projected(homography, template.points)
    fields = motion_fields(template.points)
    (_, (middle,)) = _projected(homography, np.zeros((1, 2)))
    growth = abs(float(np.linalg.det(middle))) / float(np.prod(template.half))
    noise = 0.5 * rest / NOISE * template.correlation
    here = (jacobians @ fields).reshape(MOTIONS, MOTIONS)
    taught = (template.half[:, None] * fields).reshape(MOTIONS, MOTIONS)
    model = MODEL_SIGMA**2 * np.eye(MOTIONS)
    return AlignedPatch(
        pixels + low,
        noise / growth * here @ inverse @ here.T + model,
        noise * taught @ inverse @ taught.T + model,
        _projected(homography, template.corners)[0] + low,
    )


def _projected(
    homography: NDArray[np.float64], places: NDArray[np.float64]
) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """Return the projections of patch coordinates, shape (n, 2), and their Jacobians, shape (n, 2, 2)."""
    projected = places @ homography[:, :2].T + homography[:, 2]
    pixels = projected[:, :2] / projected[:, 2:]
    by_places = homography[None, :2, :2] - pixels[:, :, None] * homography[None, 2:, :2]
    return pixels, by_places / projected[:, 2, None, None]
