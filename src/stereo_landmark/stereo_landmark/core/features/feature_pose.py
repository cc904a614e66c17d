"""Finds the pose from features alone: hypotheses by P3P and LO-RANSAC, then patches aligned at the predicted pixels."""

from __future__ import annotations

from dataclasses import dataclass

import cv2
import numpy as np

from stereo_landmark.core.arrays import Floats, GreyImage, Ints, Masks
from stereo_landmark.core.features.image_features import ImageFeatures, detect_features, match_features
from stereo_landmark.core.features.patch_alignment import align_patches, smooth
from stereo_landmark.core.features.taught_features import TaughtFeatures
from stereo_landmark.core.place.reprojection import reproject
from stereo_landmark.core.stereo import StereoRig
from shirube_core.geometry import gravity_aligned_camera
from scipy.spatial.transform import Rotation

PIXEL_GATE = 4.0
INLIERS_MIN = 12
RANSAC_ITERATIONS = 500


def find_state(taught: TaughtFeatures, seen: ImageFeatures, rig: StereoRig, matches: Ints) -> tuple[Floats, Masks] | None:
    """Return x, y, z, yaw, roll, pitch of the base in the place's frame by P3P, and mask of inliers among matches."""
    if len(matches) < INLIERS_MIN:
        return None
    points, pixels = taught.positions[matches[:, 0]], seen.pixels[matches[:, 1]]
    good, turn, shift, inliers = cv2.solvePnPRansac(
        points, pixels, rig.left.matrix, None, iterationsCount=RANSAC_ITERATIONS, reprojectionError=PIXEL_GATE,
        confidence=0.9999, flags=cv2.SOLVEPNP_P3P,
    )
    if not good or inliers is None or len(inliers) < 6:
        return None
    inliers = inliers.ravel()
    turn, shift = cv2.solvePnPRefineLM(points[inliers], pixels[inliers], rig.left.matrix, None, turn, shift)
    R_optical_place = cv2.Rodrigues(turn)[0]
    mask = np.zeros(len(matches), dtype=bool)
    mask[inliers] = True
    eye = -R_optical_place.T @ shift.ravel()
    R_place_base = R_optical_place.T @ rig.mount.rotation.T
    position = eye - R_place_base @ np.array(rig.mount.xyz)
    roll, pitch, yaw = Rotation.from_matrix(R_place_base).as_euler('xyz')
    return np.array([*position, yaw, roll, pitch]), mask


def measure(taught: TaughtFeatures, state: Floats, images: tuple[Floats, Floats], rig: StereoRig):
    """Align all taught features at the pose. Return pixels (n,4), cov (n,4,4), mask."""
    view = reproject(state, taught.positions, rig)
    camera = gravity_aligned_camera(taught.rig.mount, *taught.tilt)
    depths = ((taught.positions - camera.position) @ camera.rotation)[:, 2]
    axes = depths[:, None, None] / taught.rig.left.fx * camera.rotation[None, :, :2]
    n = len(taught)
    pixels, covs = np.empty((n, 4)), np.zeros((n, 4, 4))
    ok = view.in_front.copy()
    for side in (0, 1):
        part = slice(2 * side, 2 * side + 2)
        maps = view.point_jacobian[:, part] @ axes
        starts = view.pixels[:, part].copy()
        if side == 1:
            starts[ok] += pixels[ok, :2] - view.pixels[ok, :2]
        found = align_patches(taught.template, taught.features.pixels, images[side], starts, maps)
        pixels[:, part], covs[:, part, part] = found.pixels, found.covariances
        ok &= (found.correlations >= 0.8) & (np.hypot(*(found.pixels - view.pixels[:, part]).T) <= PIXEL_GATE)
    return pixels, covs, ok
