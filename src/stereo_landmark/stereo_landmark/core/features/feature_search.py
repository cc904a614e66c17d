"""Finds the pose by features alone: P3P and RANSAC (Fischler & Bolles 1981), then patches at the predicted pixels."""

from dataclasses import dataclass
from functools import cached_property

import cv2
import numpy as np
from scipy.spatial.transform import Rotation

from stereo_landmark.core.arrays import Floats, GreyImage, Ints
from stereo_landmark.core.features.patch_alignment import align_patches, smooth
from stereo_landmark.core.features.taught_features import ImageFeatures, TaughtFeatures, detect_features, match_features
from stereo_landmark.core.place.joint_fit import reproject
from stereo_landmark.core.stereo import MEASUREMENT_SIZE, StereoRig

PIXEL_GATE = 4.0
"""Maximum distance of a feature from its predicted pixel [px]."""
INLIERS_MIN = 12
"""Minimum number of features for a pose."""
RANSAC_ITERATIONS = 500
CORRELATION_MIN = 0.8
"""Minimum correlation of a feature with the taught one."""
BORDER = 16.0
"""Features predicted nearer to the border may be out of view [px]."""
MEASURED_MAX = 300
"""Maximum number of features that are measured."""


@dataclass(frozen=True, eq=False)
class SeenImages:
    """The current pair, of which features are computed when they are first needed.

    Attributes:
        left: rectified grey image of the left camera, shape (h, w).
        right: rectified grey image of the right camera, shape (h, w).
    """

    left: GreyImage
    right: GreyImage

    @cached_property
    def features(self) -> ImageFeatures:
        """Features of the left image."""
        return detect_features(self.left)

    @cached_property
    def smoothed(self) -> tuple[Floats, Floats]:
        """Both images, smoothed for the alignment of patches."""
        return smooth(self.left), smooth(self.right)


@dataclass(frozen=True, eq=False)
class MeasuredFeatures:
    """Taught features that the current pair shows at a pose.

    Attributes:
        indices: indices of the taught features, shape (n,).
        pixels: u, v left and u, v right, shape (n, 4) [px].
        covariances: their covariances, shape (n, 4, 4) [px²].
        expected: number of features that should be visible.
    """

    indices: Ints
    pixels: Floats
    covariances: Floats
    expected: int

    def __len__(self) -> int:
        return len(self.indices)

    @property
    def fraction(self) -> float:
        """Fraction of the expected features that are seen."""
        return len(self) / max(self.expected, 1)


class FeatureSearch:
    """Finds and measures the features of a place."""

    def __init__(self, taught: TaughtFeatures, rig: StereoRig) -> None:
        self._taught, self._rig = taught, rig
        step = -(-len(taught) // MEASURED_MAX) or 1
        self._measured = np.arange(0, len(taught), step)

    @property
    def count(self) -> int:
        """Number of features that can be measured."""
        return len(self._measured)

    def find(self, seen: ImageFeatures) -> Floats | None:
        """Return x, y, z [m], yaw, roll, pitch [rad] of the robot in the place, shape (6,); None if unknown."""
        return self._consensus(seen, match_features(self._taught.features, seen))

    def find_rival(self, seen: ImageFeatures, state: Floats) -> Floats | None:
        """Return another pose, to which features at other pixels than those of a pose belong; None without one.

        Objects that repeat have several similar features, of which each may be the taught one.
        """
        matches = match_features(self._taught.features, seen, 3)
        view = reproject(state, self._taught.points.positions[matches[:, 0]], self._rig)
        away = np.hypot(*(view.pixels[:, :2] - seen.pixels[matches[:, 1]]).T) > 3.0 * PIXEL_GATE
        return self._consensus(seen, matches[away])

    def _consensus(self, seen: ImageFeatures, matches: Ints) -> Floats | None:
        """Return the state with the most inliers among matches."""
        if len(matches) < INLIERS_MIN:
            return None
        points, pixels = self._taught.points.positions[matches[:, 0]], seen.pixels[matches[:, 1]]
        matrix, rig = self._rig.left.matrix, self._rig
        # OpenCV's RANSAC draws the same samples in each call.
        is_found, turn, shift, inliers = cv2.solvePnPRansac(
            *(points, pixels, matrix, None),
            iterationsCount=RANSAC_ITERATIONS,
            reprojectionError=PIXEL_GATE,
            confidence=0.9999,
            flags=cv2.SOLVEPNP_P3P,
        )
        if not is_found or inliers is None or len(inliers) < INLIERS_MIN:
            return None
        kept = np.sort(inliers.ravel())
        turn, shift = cv2.solvePnPRefineLM(points[kept], pixels[kept], matrix, None, turn, shift)
        R_place_optical = np.asarray(cv2.Rodrigues(turn)[0]).T
        R_place_base = R_place_optical @ rig.mount.rotation.T
        position = -R_place_optical @ np.asarray(shift).ravel() - R_place_base @ np.array(rig.mount.xyz)
        roll, pitch, yaw = Rotation.from_matrix(R_place_base).as_euler('xyz')
        return np.array([*position, yaw, roll, pitch])

    def measure(self, state: Floats, images: SeenImages) -> MeasuredFeatures:
        """Return the features that the current pair shows where a state, shape (6,), predicts them."""
        chosen, taught = self._measured, self._taught
        view = reproject(state, taught.points.positions[chosen], self._rig)
        size = np.array([self._rig.left.width, self._rig.left.height])
        inside = (view.pixels[:, :2] > BORDER) & (view.pixels[:, :2] < size - 1.0 - BORDER)
        kept = np.flatnonzero(view.in_front & inside.all(axis=1) & (view.pixels[:, 2] > BORDER))
        expected, pixels = len(kept), np.empty((len(chosen), MEASUREMENT_SIZE))
        covariances = np.zeros((len(chosen), MEASUREMENT_SIZE, MEASUREMENT_SIZE))
        for side, image in enumerate(images.smoothed):
            part = slice(2 * side, 2 * side + 2)
            predicted = view.pixels[kept, part]
            # The right image is off by the same error of the state, once the left one is known.
            starts = predicted + (pixels[kept, :2] - view.pixels[kept, :2] if side else 0.0)
            maps = view.point_jacobian[kept, part] @ taught.axes[chosen[kept]]
            found = align_patches(taught.patches, chosen[kept], image, starts, maps)
            pixels[kept, part], covariances[kept, part, part] = found.pixels, found.covariances
            is_near = np.hypot(*(found.pixels - predicted).T) <= PIXEL_GATE
            kept = kept[(found.correlations >= CORRELATION_MIN) & is_near]
        return MeasuredFeatures(chosen[kept], pixels[kept], covariances[kept], expected)
