"""The patches of a place: points measured by the texture within a primitive instead of its outline.

Each quadrilateral of the taught left image is a patch. It is aligned once with the taught right image, which gives its
3D points, and then with each new pair. Grain, text and edges that cross the outline are the same in all four images,
so only image noise causes errors. To first order, aligning all images with the taught left one is the joint adjustment
of all four, each with its own noise.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from typing import NamedTuple

import cv2
import numpy as np

from stereo_landmark.core.arrays import Floats, GreyImage, Ints
from stereo_landmark.core.patches.patch_fit import HOMOGRAPHY_DOF, fit_patch
from stereo_landmark.core.patches.patch_template import (
    NOISE_GAIN,
    PatchTemplate,
    homography_jacobian,
    patch_template,
    spline_coefficients,
)
from stereo_landmark.core.place.joint_fit import reproject
from stereo_landmark.core.primitives.quadrilateral import Quadrilateral
from stereo_landmark.core.procedure.taught_place import TaughtPlace
from stereo_landmark.core.stereo import (
    MEASUREMENT_SIZE,
    SpatialPoints,
    StereoPoints,
    TiltedCameras,
    add_calibration_noise,
    is_in_same_row,
    is_measurable,
)

ImagePair = tuple[GreyImage, GreyImage]
CORNER_COUNT = 4
GATE_SIGMAS = 4.0
OUTLINE_SIGMA = 0.03
"""Model error of outlines by uneven light and nearby edges, standard deviation [px]."""


@dataclass(frozen=True)
class TaughtPatch:
    """A patch and its 3D points.

    Attributes:
        primitive: name of the primitive as ``target/primitive``.
        template: template from the taught left image.
        points: 3D points in the place frame, named after the corners of the primitive.
    """

    primitive: str
    template: PatchTemplate
    points: SpatialPoints


class MeasuredPoints(NamedTuple):
    """Points of the present pair and their taught positions.

    Attributes:
        seen: points in both present images.
        taught: all taught points in the place frame, also those not seen.
        matched_patches: names of the primitives that were measured by patches; the others were measured by outlines.
    """

    seen: StereoPoints
    taught: SpatialPoints
    matched_patches: tuple[str, ...]


class TaughtPatches:
    """The patches of one place.

    Args:
        place: taught place; one without images has no patches.
        pixel_sigma: standard deviation of the calibration error [px].
    """

    def __init__(self, place: TaughtPlace, pixel_sigma: float) -> None:
        self._place, self._pixel_sigma = place, pixel_sigma
        self._patches = list(self._prepare_patches())

    def measure(self, seen: StereoPoints, images: ImagePair) -> MeasuredPoints:
        """Measure points by their patches.

        Points without a patch, or whose patch cannot be aligned, remain unchanged.

        Args:
            seen: points of the primitives, measured by outlines.
            images: present left and right grey images, each of shape (h, w).
        """
        coordinates = self._place.coordinates
        pixels, covariances = seen.pixels.copy(), seen.covariances.copy()
        positions, position_covariances = coordinates.positions.copy(), coordinates.covariances.copy()
        rows_by_name = {name: k for k, name in enumerate(seen.names)}
        taught_rows_by_name = {name: k for k, name in enumerate(coordinates.names)}
        matched_patches = []
        for patch in self._patches:
            if patch.points.names[0] not in rows_by_name:
                continue
            rows = [rows_by_name[name] for name in patch.points.names]
            found = _align_in_both(patch.template, seen.pixels[rows], seen.covariances[rows], images)
            if found is not None:
                pixels[rows], covariances[rows] = found
                taught = [taught_rows_by_name[name] for name in patch.points.names]
                positions[taught], position_covariances[taught] = (patch.points.positions, patch.points.covariances)
                matched_patches.append(patch.primitive)
        return MeasuredPoints(
            StereoPoints(seen.names, pixels, covariances),
            SpatialPoints(coordinates.names, positions, position_covariances),
            tuple(matched_patches),
        )

    def _prepare_patches(self) -> Iterator[TaughtPatch]:
        images = self._place.images
        if images is None:
            return
        for target in self._place.targets:
            for primitive in target.primitives:
                if isinstance(primitive.shape, Quadrilateral):
                    template = patch_template(images.left, primitive.shape.corners)
                    name = f'{target.name}/{primitive.name}'
                    names = tuple(f'{name}/corner_{k}' for k in range(CORNER_COUNT))
                    points = None if template is None else self._triangulate_points(template, names, images.right)
                    if template is not None and points is not None:
                        yield TaughtPatch(name, template, points)

    def _triangulate_points(
        self, template: PatchTemplate, names: tuple[str, ...], right: GreyImage
    ) -> SpatialPoints | None:
        """Triangulate the points of a patch; None if it cannot be aligned with the taught right image."""
        place = self._place
        rig = place.rig if place.pair is None else place.pair.rig
        tilt = (0.0, 0.0) if place.images is None else place.images.tilt
        corners = place.coordinates.select(names).positions
        start = reproject(np.array([0.0, 0.0, 0.0, 0.0, *tilt]), corners, rig).pixels[:, 2:]
        found = align_patch(template, right, start)
        if found is None:
            return None
        covariances = _stereo_covariances(found.taught_covariance, found.covariance)
        seen = StereoPoints(names, np.hstack([template.pixels, found.points]), covariances)
        if not (is_measurable(seen, rig) & is_in_same_row(seen, self._pixel_sigma)).all():
            return None
        return TiltedCameras(rig, tilt).spatial_points(add_calibration_noise(seen, self._pixel_sigma))


def _align_in_both(
    template: PatchTemplate, corners: Floats, covariances: Floats, images: ImagePair
) -> tuple[Floats, Floats] | None:
    """Return the points of a patch in both images and their covariances, shapes (4, 4) and (4, 4, 4).

    The corners are measured by the outline: u, v left and u, v right, with covariances; None without an alignment.
    """
    found = []
    for image, part in zip(images, (slice(0, 2), slice(2, 4)), strict=True):
        aligned = align_patch(template, image, corners[:, part])
        if aligned is None or not _agrees_with_outline(aligned, corners[:, part], covariances[:, part, part]):
            return None
        found.append(aligned)
    left, right = found
    return np.hstack([left.points, right.points]), _stereo_covariances(left.covariance, right.covariance)


def _agrees_with_outline(aligned: AlignedPatch, corners: Floats, covariances: Floats) -> bool:
    """Return whether a patch agrees with its outline within the uncertainty of both."""
    variances = 2.0 * np.diagonal(covariances, axis1=1, axis2=2) + OUTLINE_SIGMA**2
    variances = variances + np.diag(aligned.covariance).reshape(CORNER_COUNT, 2)
    return bool((np.abs(aligned.corners - corners) <= GATE_SIGMAS * np.sqrt(variances)).all())


def _stereo_covariances(left: Floats, right: Floats) -> Floats:
    """Return the stereo covariance of each of four points, shape (4, 4, 4), from two of shape (8, 8)."""
    blocks = np.zeros((CORNER_COUNT, MEASUREMENT_SIZE, MEASUREMENT_SIZE))
    for k in range(CORNER_COUNT):
        own = slice(2 * k, 2 * k + 2)
        blocks[k, :2, :2], blocks[k, 2:, 2:] = left[own, own], right[own, own]
    return blocks


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
    homography = cv2.getPerspectiveTransform(template.corners.astype(np.float32), (start - low).astype(np.float32))
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
