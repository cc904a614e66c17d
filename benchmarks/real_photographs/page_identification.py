"""Which page is it, and where are its dots: brute force over all pages and turns, the benchmark's own truth.

It shares nothing with the product's matcher. The frame gives a page's pose but for quarter turns, so that 120
pages of 30 dots under four turns are all there is to try.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import cv2
import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]

COARSE = 0.0035  # radius of a match behind a rough frame [m]
FINE = 0.001  # radius of a match behind a homography of the dots [m]
MINIMUM_MATCHES = 12
MINIMUM_LEAD = 4  # of the best page over the second


@dataclass(frozen=True)
class PagePose:
    """A page in an image, by its dots.

    Attributes:
        page: index of the page.
        homography: shape (3, 3), takes points of the page [m] to the undistorted image [px].
        matches: number of the page's dots that were seen.
        residual: root mean square distance of the seen dots from the page's [m].
    """

    page: int
    homography: Array
    matches: int
    residual: float


def transform_points(homography: NDArray[np.floating[Any]], points: Array) -> Array:
    """Take points, shape (n, 2), through a homography."""
    return cv2.perspectiveTransform(points.reshape(-1, 1, 2), homography).reshape(-1, 2)


def identify_page(corners: Array, frame: Array, dots: Array, pages: list[Array]) -> PagePose | None:
    """Return the page in a frame, None where no page fits clearly better than all others.

    Args:
        corners: shape (4, 2), the frame's corners in the image, clockwise as seen [px].
        frame: shape (4, 2), the corners of a frame on the page in the same order [m].
        dots: shape (n, 2), the dots seen in the image [px].
        pages: the dots of each page, shape (30, 2) [m], x right and y up as printed.
    """
    inside = [
        cv2.pointPolygonTest(corners.astype(np.float32), (float(u), float(v)), False) > 0 for u, v in dots
    ]
    seen = dots[np.array(inside, dtype=bool)]
    if len(seen) < MINIMUM_MATCHES:
        return None
    tries = []
    for turn in range(4):
        start = cv2.getPerspectiveTransform(
            np.roll(frame, turn, axis=0).astype(np.float32), corners.astype(np.float32)
        ).astype(np.float64)
        on_page = transform_points(np.linalg.inv(start), seen)
        for index, page in enumerate(pages):
            gap = np.linalg.norm(on_page[:, None] - page[None], axis=2)
            tries.append(
                (min((gap.min(axis=0) < COARSE).sum(), (gap.min(axis=1) < COARSE).sum()), index, start)
            )
    tries.sort(key=lambda a_try: -a_try[0])
    poses = [fit_page(index, pages[index], start, seen) for _, index, start in tries[:8]]
    fits = sorted((pose for pose in poses if pose is not None), key=lambda pose: -pose.matches)
    if not fits or fits[0].matches < MINIMUM_MATCHES:
        return None
    others = [pose.matches for pose in fits if pose.page != fits[0].page]
    return fits[0] if not others or fits[0].matches >= others[0] + MINIMUM_LEAD else None


def fit_page(index: int, page: Array, start: Array, dots: Array) -> PagePose | None:
    """Return the least-squares homography of a page's dots near a first guess, None below 8 matches."""
    homography = start
    for radius in (COARSE, COARSE, 2.0 * FINE, FINE, FINE, FINE):
        on_page = transform_points(np.linalg.inv(homography), dots)
        gap = np.linalg.norm(on_page[:, None] - page[None], axis=2)
        nearest, back = gap.argmin(axis=1), gap.argmin(axis=0)
        chosen = np.nonzero((gap.min(axis=1) < radius) & (back[nearest] == np.arange(len(dots))))[0]
        if len(chosen) < 8:
            return None
        fitted, _ = cv2.findHomography(page[nearest[chosen]], dots[chosen], 0)
        if fitted is None or not np.isfinite(fitted).all() or abs(np.linalg.det(fitted)) < 1e-12:
            return None
        homography = fitted
    residual = float(np.sqrt((gap.min(axis=1)[chosen] ** 2).mean()))
    return PagePose(index, homography, len(chosen), residual)
