"""The patches of a place: points measured by what is seen within a primitive instead of along its outline.

Each quadrilateral of the taught left image is a patch. Once it is found in the taught right image, which places its
points in space, and then in each new pair. What all four images show of it has only their noise in common with the
truth: grain, texts and whatever crosses the outline are the same in all of them. To first order, comparing all with
the taught left image is the adjustment of all four, each with the noise of its own.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from shirube_geometry import level_camera
from stereo_landmark.core.patches.patch_alignment import AlignedPatch, align_patch
from stereo_landmark.core.patches.patch_template import PatchTemplate, patch_template
from stereo_landmark.core.place.reprojection_model import reproject
from stereo_landmark.core.place.stereo_points import (
    SpatialPoints,
    StereoPoints,
    measurable,
    rows_agree,
    triangulate,
    with_calibration_error,
)
from stereo_landmark.core.place.stereo_rig import MEASURED
from stereo_landmark.core.primitives.quadrilateral import Quadrilateral
from stereo_landmark.core.procedure.taught_place import TaughtPlace

Pair = tuple[NDArray[np.uint8], NDArray[np.uint8]]
CORNERS = 4
GATE_SIGMAS = 4.0
OUTLINE_SIGMA = 0.03
"""Outlines are off by so much where light and what lies beside them are not as their model has it [px]."""


@dataclass(frozen=True)
class TaughtPatch:
    """A patch and its points.

    Attributes:
        primitive: its name, with that of its target.
        template: as the taught left image shows it.
        points: in the place's frame, named after the corners of the primitive.
    """

    primitive: str
    template: PatchTemplate
    points: SpatialPoints


@dataclass(frozen=True)
class MeasuredPoints:
    """Points of now and where they were taught.

    Attributes:
        seen: in both images.
        taught: in the place's frame; more than were seen.
        compared: names of the primitives whose patches tell their points; outlines tell the others.
    """

    seen: StereoPoints
    taught: SpatialPoints
    compared: tuple[str, ...]


class TaughtPatches:
    """The patches of one place.

    Args:
        place: as taught; one without images has no patches.
        pixel_sigma: error of the calibration [px].
    """

    def __init__(self, place: TaughtPlace, pixel_sigma: float) -> None:
        self._place, self._pixel_sigma = place, pixel_sigma
        self._patches = list(self._prepared())

    def measured(self, seen: StereoPoints, images: Pair) -> MeasuredPoints:
        """Return points as the patches tell them.

        Points of what is no patch, or is not found as it was taught, stay as they are.

        Args:
            seen: points of primitives, measured along outlines.
            images: of now, shapes (h, w).
        """
        coordinates = self._place.coordinates
        pixels, covariances = seen.pixels.copy(), seen.covariances.copy()
        positions, spreads = coordinates.positions.copy(), coordinates.covariances.copy()
        numbers = {name: k for k, name in enumerate(seen.names)}
        taught_numbers = {name: k for k, name in enumerate(coordinates.names)}
        compared = []
        for patch in self._patches:
            if patch.points.names[0] not in numbers:
                continue
            rows = [numbers[name] for name in patch.points.names]
            found = _in_both(patch.template, seen.pixels[rows], seen.covariances[rows], images)
            if found is not None:
                pixels[rows], covariances[rows] = found
                taught = [taught_numbers[name] for name in patch.points.names]
                positions[taught], spreads[taught] = patch.points.positions, patch.points.covariances
                compared.append(patch.primitive)
        return MeasuredPoints(
            StereoPoints(seen.names, pixels, covariances),
            SpatialPoints(coordinates.names, positions, spreads),
            tuple(compared),
        )

    def _prepared(self) -> Iterator[TaughtPatch]:
        images = self._place.images
        if images is None:
            return
        for target in self._place.targets:
            for primitive in target.primitives:
                if isinstance(primitive.shape, Quadrilateral):
                    template = patch_template(images.left, primitive.shape.corners)
                    name = f'{target.name}/{primitive.name}'
                    names = tuple(f'{name}/corner_{k}' for k in range(CORNERS))
                    points = None if template is None else self._points(template, names, images.right)
                    if template is not None and points is not None:
                        yield TaughtPatch(name, template, points)

    def _points(
        self, template: PatchTemplate, names: tuple[str, ...], right: NDArray[np.uint8]
    ) -> SpatialPoints | None:
        """Return the points of a patch in space, None where the taught right image does not show it."""
        place, rig = self._place, self._place.rig
        tilt = (0.0, 0.0) if place.images is None else place.images.tilt
        corners = place.coordinates.selected(names).positions
        start = reproject(np.array([0.0, 0.0, 0.0, 0.0, *tilt]), corners, rig).pixels[:, 2:]
        found = align_patch(template, right, start)
        if found is None:
            return None
        covariances = _blocks(found.taught_covariance, found.covariance)
        seen = StereoPoints(names, np.hstack([template.pixels, found.points]), covariances)
        if not (measurable(seen, rig) & rows_agree(seen, self._pixel_sigma)).all():
            return None
        camera = level_camera(rig.mount, *tilt)
        noisy = with_calibration_error(seen, self._pixel_sigma)
        return triangulate(noisy, rig).moved(camera.rotation, camera.position)


def _in_both(
    template: PatchTemplate, corners: NDArray[np.float64], covariances: NDArray[np.float64], images: Pair
) -> tuple[NDArray[np.float64], NDArray[np.float64]] | None:
    """Return the points of a patch in both images, shapes (4, 4) and (4, 4, 4), None where one does not show it.

    Args:
        template: of the patch.
        corners: as measured along its outline, u, v left and u, v right, shape (4, 4) [px].
        covariances: of these, shape (4, 4, 4) [px²].
        images: of now.
    """
    found = []
    for image, part in zip(images, (slice(0, 2), slice(2, 4)), strict=True):
        aligned = align_patch(template, image, corners[:, part])
        if aligned is None or not _agrees(aligned, corners[:, part], covariances[:, part, part]):
            return None
        found.append(aligned)
    left, right = found
    return np.hstack([left.points, right.points]), _blocks(left.covariance, right.covariance)


def _agrees(aligned: AlignedPatch, corners: NDArray[np.float64], covariances: NDArray[np.float64]) -> bool:
    """Tell whether a patch is where its outline is, as far as that is known, here and in the taught image."""
    variances = 2.0 * np.diagonal(covariances, axis1=1, axis2=2) + OUTLINE_SIGMA**2
    variances = variances + np.diag(aligned.covariance).reshape(CORNERS, 2)
    return bool((np.abs(aligned.corners - corners) <= GATE_SIGMAS * np.sqrt(variances)).all())


def _blocks(left: NDArray[np.float64], right: NDArray[np.float64]) -> NDArray[np.float64]:
    """Return the covariances of each of four points in both images, shape (4, 4, 4), of shapes (8, 8)."""
    blocks = np.zeros((CORNERS, MEASURED, MEASURED))
    for k in range(CORNERS):
        own = slice(2 * k, 2 * k + 2)
        blocks[k, :2, :2], blocks[k, 2:, 2:] = left[own, own], right[own, own]
    return blocks
