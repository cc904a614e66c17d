"""Features of a taught pair with their points in space."""

from __future__ import annotations

from dataclasses import dataclass

import cv2
import numpy as np

from shirube_core.geometry import gravity_aligned_camera
from stereo_landmark.core.arrays import Floats
from stereo_landmark.core.features.image_features import ImageFeatures, detect_features
from stereo_landmark.core.features.patch_alignment import align_patches, smooth
from stereo_landmark.core.features.row_search import search_rows
from stereo_landmark.core.stereo import StereoImages, StereoRig

DISPARITY_MIN = 1.5
"""Features farther away are left out [px]."""
DEPTH_MIN = 0.3
"""[m]."""
CORRELATION_MIN = 0.85
ROW_DIFFERENCE_MAX = 1.5
"""[px]."""


@dataclass(frozen=True, eq=False)
class TaughtFeatures:
    """Features of a taught pair.

    Attributes:
        features: features in the taught left image.
        template: smoothed taught left image, shape (h, w).
        pixels: u, v left and u, v right, shape (n, 4) [px].
        variances: variances of u and v right, shape (n, 2) [px²].
        positions: points in the place's frame, shape (n, 3) [m].
        camera_position: left camera at teaching in the place's frame, shape (3,) [m].
        rig: cameras at teaching.
        tilt: roll, pitch at teaching.
    """

    features: ImageFeatures
    template: Floats
    pixels: Floats
    covariances: Floats
    positions: Floats
    rig: StereoRig
    tilt: tuple[float, float]

    def __len__(self) -> int:
        return len(self.pixels)


def teach_features(images: StereoImages, rig: StereoRig) -> TaughtFeatures:
    """Return the features that both images of a taught pair show."""
    found = detect_features(images.left)
    left, right = smooth(images.left), smooth(images.right)
    half = [cv2.resize(each, None, fx=0.5, fy=0.5, interpolation=cv2.INTER_AREA) for each in (left, right)]
    offset = rig.left.cx - rig.right.cx
    scale = rig.left.fx * rig.baseline
    count = len(found)
    disparities, unique = search_rows(
        half[0], half[1], 0.5 * found.pixels - 0.25,
        np.full(count, 0.5 * (scale / DEPTH_MIN + offset)), np.full(count, 0.5 * offset),
    )
    starts = found.pixels - np.column_stack([2.0 * disparities, np.zeros(count)])
    aligned = align_patches(left, found.pixels, right, starts, np.tile(np.eye(2), (count, 1, 1)))
    disparity = found.pixels[:, 0] - aligned.pixels[:, 0] - offset
    good = (
        unique
        & (aligned.correlations >= CORRELATION_MIN)
        & (np.abs(aligned.pixels[:, 1] - found.pixels[:, 1]) <= ROW_DIFFERENCE_MAX)
        & (np.abs(aligned.pixels[:, 0] - starts[:, 0]) <= 4.0)
        & (disparity >= DISPARITY_MIN)
    )
    z = scale / disparity[good]
    here = found.pixels[good]
    v = 0.5 * (here[:, 1] + aligned.pixels[good, 1])
    optical = np.column_stack([(here[:, 0] - rig.left.cx) / rig.left.fx * z, (v - rig.left.cy) / rig.left.fy * z, z])
    camera = gravity_aligned_camera(rig.mount, *images.tilt)
    return TaughtFeatures(
        ImageFeatures(here, found.descriptors[good]),
        left,
        np.hstack([here, aligned.pixels[good]]),
        aligned.covariances[good],
        optical @ camera.rotation.T + camera.position,
        rig,
        images.tilt,
    )
