"""Whether a frame's corners are to be seen, judged where the dots say that they are."""

from __future__ import annotations

import cv2
import numpy as np
from numpy.typing import NDArray
from page_identification import transform_points

Array = NDArray[np.float64]
Image = NDArray[np.uint8]

ALONG = np.linspace(0.001, 0.005, 9)  # of the edges, from the corner [m]
ASIDE = 0.002  # distance from an edge at which the page and its surroundings are sampled [m]
BORDER = 3.0  # of the image [px]
WHITE = 0.8  # least brightness of the page, relative to its middle
DARK = 0.9  # greatest brightness of a card's surroundings, relative to its middle
LINE = 0.95  # greatest brightness of a printed line, relative to the page next to it
SHARE = 0.7  # of the places along an edge that must look right


def visible_corners(
    image: Image, homography: Array, outline: Array, *, is_printed: bool
) -> NDArray[np.bool_]:
    """Return which corners of a frame are seen, shape (4,).

    Args:
        image: grey, undistorted.
        homography: shape (3, 3), takes points of the page [m] to the image [px], from the page's dots.
        outline: shape (4, 2), the frame's corners on the page [m], clockwise.
        is_printed: whether the frame is a thin dark line on white; else it is a white page's edge.
    """
    middle = outline.mean(axis=0)
    grid = np.stack(np.meshgrid(*[np.linspace(-0.6, 0.6, 13)] * 2), axis=-1).reshape(-1, 2)
    inside = middle + grid * np.abs(outline - middle).min(axis=0)
    white = float(np.percentile(_levels(image, homography, inside), 70.0))
    seen = np.zeros(4, dtype=bool)
    for k in range(4):
        corner = outline[k]
        pixel = transform_points(homography, corner[None])[0]
        size = np.array([image.shape[1], image.shape[0]])
        if (pixel < BORDER).any() or (pixel > size - 1.0 - BORDER).any():
            continue
        before, after = outline[k - 1] - corner, outline[(k + 1) % 4] - corner
        edges = (before / np.linalg.norm(before), 1.0), (after / np.linalg.norm(after), -1.0)
        seen[k] = all(_is_edge_visible(image, homography, corner, *edge, white, is_printed) for edge in edges)
    return seen


def _is_edge_visible(
    image: Image, homography: Array, corner: Array, along: Array, side: float, white: float, is_printed: bool
) -> bool:
    inward = side * np.array([-along[1], along[0]])
    points = corner + ALONG[:, None] * along
    inside = _levels(image, homography, points + ASIDE * inward)[ALONG > ASIDE]
    outside = _levels(image, homography, points - ASIDE * inward)[ALONG > ASIDE]
    bright = inside > WHITE * white
    if is_printed:
        on_line = _levels(image, homography, points)[ALONG > ASIDE]
        good = bright & (on_line < LINE * inside)
    else:
        good = bright & (outside < DARK * white)
    return bool(good.mean() >= SHARE)


def _levels(image: Image, homography: Array, points: Array) -> Array:
    pixels = transform_points(homography, points).astype(np.float32).reshape(1, -1, 2)
    levels = cv2.remap(
        image, pixels[..., 0], pixels[..., 1], cv2.INTER_LINEAR, borderMode=cv2.BORDER_CONSTANT, borderValue=0
    )
    return levels[0].astype(np.float64)
