"""Dots on a bright page, found plainly: a second opinion that shares nothing with the product's detector."""

from __future__ import annotations

import cv2
import numpy as np
from numpy.typing import NDArray

ENLARGEMENT = 2
BACKGROUND_WINDOW = 31  # larger than a dot in the enlarged image [px]
DARKNESS = 0.3  # of a dot, relative to the page round it


def find_page_dots(image: NDArray[np.uint8]) -> NDArray[np.float64]:
    """Return the centroids u, v of small dark spots on bright ground in a grey image, shape (n, 2) [px]."""
    large = cv2.resize(image, None, fx=ENLARGEMENT, fy=ENLARGEMENT, interpolation=cv2.INTER_CUBIC)
    window = cv2.getStructuringElement(cv2.MORPH_ELLIPSE, (BACKGROUND_WINDOW, BACKGROUND_WINDOW))
    ground = cv2.morphologyEx(large, cv2.MORPH_CLOSE, window)
    depth = cv2.subtract(ground, large).astype(np.float64)
    _, labels, stats, centres = cv2.connectedComponentsWithStats((depth > DARKNESS * ground).astype(np.uint8))
    white = 0.6 * np.percentile(image, 99.0)
    dots = []
    for label in range(1, len(stats)):
        x, y, width, height, area = stats[label]
        u, v = np.round(centres[label]).astype(int)
        round_enough = max(width, height) <= 3 * min(width, height) + 1 and area > 0.5 * width * height
        if 6 <= area <= 400 and round_enough and ground[v, u] > white:
            window_of_dot = (slice(y, y + height), slice(x, x + width))
            weight = np.where(labels[window_of_dot] == label, depth[window_of_dot], 0.0)
            rows, columns = np.mgrid[y : y + height, x : x + width]
            dots.append((np.average(columns, weights=weight), np.average(rows, weights=weight)))
    return (np.array(dots).reshape(-1, 2) + 0.5) / ENLARGEMENT - 0.5
