"""Where an image shows a taught patch: Gauss-Newton on grey values (Lucas & Kanade 1981).

The inverse compositional form of Baker & Matthews (2004): the derivatives are those of the taught patch, so that they
are known beforehand. Gain, offset, blur and an even change of gain across the patch are fitted along, Tukey's weights
leave out what is not as it was taught.
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
"""The patch is looked for so far around where it should be [px]."""
MODEL_SIGMA = 0.004
"""What differs between images of one plane besides noise moves a point by so much [px]."""

STRAIN_MAX = 1.6
"""Parts of a patch that want to move apart by more than this, in variances of noise, are not of one plane as taught."""


@dataclass(frozen=True)
class AlignedPatch:
    """A patch in another image.

    Attributes:
        points: of the patch, shape (4, 2) [px].
        covariance: of their coordinates, by the noise of this image, shape (8, 8) [px²].
        taught_covariance: the same for the taught image, in its pixels.
        corners: of the patch, shape (4, 2) [px].
    """

    points: NDArray[np.float64]
    covariance: NDArray[np.float64]
    taught_covariance: NDArray[np.float64]
    corners: NDArray[np.float64]


def align_patch(
    template: PatchTemplate, image: NDArray[np.uint8], start: NDArray[np.float64]
) -> AlignedPatch | None:
    """Find a patch.

    Args:
        template: as taught.
        image: shape (h, w), grey.
        start: where its corners should be, about a pixel off at most, shape (4, 2) [px].

    Returns:
        None where the image does not show it there, or something else in a large part of it.
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
    """Return the points with what the noise, half of it in either image, makes of them."""
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
    """Return where places are seen, shape (n, 2), and the derivatives by the places, shape (n, 2, 2)."""
    projected = places @ homography[:, :2].T + homography[:, 2]
    pixels = projected[:, :2] / projected[:, 2:]
    by_places = homography[None, :2, :2] - pixels[:, :, None] * homography[None, 2:, :2]
    return pixels, by_places / projected[:, 2, None, None]
