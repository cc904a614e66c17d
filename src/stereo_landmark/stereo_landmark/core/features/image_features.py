"""SIFT features (Lowe 2004) of one image with RootSIFT descriptors (Arandjelovic & Zisserman 2012), and their matches.

Features only find the pose; patches around them measure it (`patch_alignment.py`). Images are therefore halved first:
that takes a quarter of the time.
"""

from dataclasses import dataclass

import cv2
import numpy as np

from stereo_landmark.core.arrays import Floats, GreyImage, Ints

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
