"""Features of a taught pair with their points in space.

They are computed from the stored pair of a place, so that a place needs no other file, and a place of any age has them.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import cv2
import numpy as np

from shirube_core.geometry import SE3, gravity_aligned_camera
from stereo_landmark.core.arrays import Floats, GreyImage, Ints
from stereo_landmark.core.features.patch_alignment import Patches, align_patches, cut_patches, smooth
from stereo_landmark.core.stereo import (
    MEASUREMENT_SIZE,
    SpatialPoints,
    StereoImages,
    StereoPoints,
    StereoRig,
    add_calibration_noise,
    triangulate,
)

FEATURES_MAX = 1000
"""Maximum number of features of an image, the strongest ones of each cell."""
CELLS = 8, 6
"""Columns and rows of the cells over which features are spread."""
CONTRAST_MIN = 0.02
"""Contrast threshold of SIFT."""
HALVED_FROM = 400
"""Smaller images, by their longer side, are not halved [px]."""
RATIO_MAX = 0.85
"""Largest ratio of the distances of the best and the second best match (Lowe's)."""


@dataclass(frozen=True, eq=False)
class ImageFeatures:
    """Features of an image.

    Attributes:
        pixels: positions, shape (n, 2) [px].
        descriptors: RootSIFT descriptors, shape (n, 128), float32 of unit norm.
    """

    pixels: Floats
    descriptors: np.ndarray

    def __len__(self) -> int:
        return len(self.pixels)


def detect_features(image: GreyImage) -> ImageFeatures:
    """Return the features of a grey image, shape (h, w), spread over it."""
    height, width = image.shape
    factor = 2 if max(image.shape) >= HALVED_FROM else 1
    small = image[: height // factor * factor, : width // factor * factor]
    if factor > 1:
        small = cv2.resize(small, (width // factor, height // factor), interpolation=cv2.INTER_AREA)
    keypoints, descriptors = cv2.SIFT.create(contrastThreshold=CONTRAST_MIN).detectAndCompute(small, None)
    if descriptors is None:
        return ImageFeatures(np.empty((0, 2)), np.empty((0, 128), np.float32))
    pixels = factor * (np.array([each.pt for each in keypoints]) + 0.5) - 0.5
    kept = _spread(pixels, np.array([each.response for each in keypoints]), (width, height))
    descriptors = descriptors[kept] / np.maximum(descriptors[kept].sum(axis=1, keepdims=True), 1e-6)
    return ImageFeatures(pixels[kept], np.sqrt(descriptors))


def _spread(pixels: Floats, strengths: Floats, size: tuple[int, int]) -> Ints:
    """Return the indices of the strongest features of each cell, FEATURES_MAX at most."""
    columns, rows = np.clip((pixels / size * CELLS).astype(int), 0, np.array(CELLS) - 1).T
    cells = columns + CELLS[0] * rows
    order = np.lexsort([-strengths, cells])
    first = np.searchsorted(cells[order], cells[order])
    rank = np.arange(len(order)) - first
    return np.sort(order[np.argsort(rank, kind='stable')][:FEATURES_MAX])


def match_features(taught: ImageFeatures, seen: ImageFeatures, count: int = 1) -> Ints:
    """Return pairs of indices of taught and seen features, shape (m, 2).

    Args:
        taught: taught features.
        seen: features of the current image.
        count: 1 for mutual best matches that pass the ratio test; more for so many best matches of each seen feature
            without a test, as repeated objects have several.
    """
    if min(len(taught), len(seen)) < 2:
        return np.empty((0, 2), dtype=np.int64)
    similarity = seen.descriptors @ taught.descriptors.T
    if count > 1:
        best = np.argpartition(-similarity, min(count, similarity.shape[1] - 1), axis=1)[:, :count]
        here = np.repeat(np.arange(len(seen)), best.shape[1])
        good = similarity[here, best.ravel()] > SIMILARITY_MIN
        return np.column_stack([best.ravel(), here])[good]
    first = np.argmax(similarity, axis=1)
    here = np.arange(len(seen))
    highest = similarity[here, first]
    similarity[here, first] = -1.0
    second = similarity.max(axis=1)
    similarity[here, first] = highest
    distinct = 1.0 - highest <= RATIO_MAX**2 * (1.0 - second)
    mutual = np.argmax(similarity, axis=0)[first] == here
    chosen = distinct & mutual
    return np.column_stack([first, here])[chosen]


SIMILARITY_MIN = 0.8
"""Minimum similarity of the descriptors of possible matches."""


DISPARITY_MIN = 1.5
"""Features farther away are left out [px]."""
DEPTH_MIN = 0.3
"""Nearer features are left out [m]."""
CORRELATION_MIN = 0.85
"""Minimum correlation of a feature in both taught images."""
ROW_DIFFERENCE_MAX = 1.5
"""Maximum row difference of a feature in both taught images [px]."""
SEARCH_ERROR_MAX = 4.0
"""Maximum distance of the aligned patch from the pixel found by the search in the row [px]."""


@dataclass(frozen=True, eq=False)
class TaughtPair:
    """A taught pair, from which features are computed when they are first needed.

    Attributes:
        images: images used for teaching.
        rig: stereo cameras used for teaching.
    """

    images: StereoImages
    rig: StereoRig

    @cached_property
    def features(self) -> TaughtFeatures:
        """Features of the pair."""
        return teach_features(self.images, self.rig)


@dataclass(frozen=True, eq=False)
class TaughtFeatures:
    """Features of a taught pair.

    Attributes:
        features: features in the taught left image.
        patches: patches of the taught left image around them.
        points: their points in the place's frame.
        axes: derivatives of points in the plane of the image at their depth by the pixel, shape (n, 3, 2) [m/px].
    """

    features: ImageFeatures
    patches: Patches
    points: SpatialPoints
    axes: Floats

    def __len__(self) -> int:
        return len(self.points)


def teach_features(images: StereoImages, rig: StereoRig) -> TaughtFeatures:
    """Return the features that both images of a taught pair show."""
    found = detect_features(images.left)
    left, right = smooth(images.left), smooth(images.right)
    count, offset, scale = len(found), rig.left.cx - rig.right.cx, rig.left.fx * rig.baseline
    starts = _find_in_rows(found, detect_features(images.right), (offset, offset + scale / DEPTH_MIN))
    patches = cut_patches(left, found.pixels)
    aligned = align_patches(patches, np.arange(count), right, starts, np.tile(np.eye(2), (count, 1, 1)))
    shifts = np.abs(aligned.pixels - starts)
    good = (
        (aligned.correlations >= CORRELATION_MIN)
        & (shifts[:, 0] <= SEARCH_ERROR_MAX)
        & (shifts[:, 1] <= ROW_DIFFERENCE_MAX)
        & (found.pixels[:, 0] - aligned.pixels[:, 0] - offset >= DISPARITY_MIN)
    )
    here = found.pixels[good]
    covariances = np.zeros((len(here), MEASUREMENT_SIZE, MEASUREMENT_SIZE))
    covariances[:, 2:, 2:] = aligned.covariances[good]
    names = tuple(f'feature {k}' for k in range(len(here)))
    seen = StereoPoints(names, np.hstack([here, aligned.pixels[good]]), covariances)
    camera = gravity_aligned_camera(rig.mount, *images.tilt)
    optical = triangulate(add_calibration_noise(seen, PATCH_SIGMA), rig)
    return TaughtFeatures(
        ImageFeatures(here, found.descriptors[good]),
        Patches(*(each[good] for each in patches)),
        optical.transform(camera.rotation, camera.position),
        _image_axes(optical, camera, rig),
    )


PATCH_SIGMA = 0.05
"""Position error of aligned patches besides noise, standard deviation [px]; it is scaled by the residuals of a pair."""


def _find_in_rows(left: ImageFeatures, right: ImageFeatures, disparities: tuple[float, float]) -> Floats:
    """Return the pixel of the most similar right feature in the row of each left one, shape (n, 2); NaN without one."""
    shifts, rows = np.moveaxis(left.pixels[:, None] - right.pixels[None], 2, 0)
    in_row = (np.abs(rows) <= SEARCH_ERROR_MAX) & (shifts >= disparities[0]) & (shifts <= disparities[1])
    similarity = np.where(in_row, left.descriptors @ right.descriptors.T, 0.0)
    if not similarity.size:
        return np.full_like(left.pixels, np.nan)
    best, here = similarity.argmax(axis=1), np.arange(len(left))
    is_mutual = (similarity.argmax(axis=0)[best] == here) & (similarity[here, best] >= SIMILARITY_MIN)
    starts = np.column_stack([right.pixels[best, 0], left.pixels[:, 1]])
    return np.where(is_mutual[:, None], starts, np.nan)


def _image_axes(optical: SpatialPoints, camera: SE3, rig: StereoRig) -> Floats:
    """Return the derivatives of points by the pixel in planes parallel to the image, shape (n, 3, 2) [m/px]."""
    focal = np.array([rig.left.fx, rig.left.fy])
    return np.asarray(optical.positions[:, 2, None, None] * camera.rotation[:, :2] / focal)
