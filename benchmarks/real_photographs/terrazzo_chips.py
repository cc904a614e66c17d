"""The chips of the terrazzo picture by a plain threshold, to count which of them the detector finds."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import cv2
import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]
Image = NDArray[np.uint8]

FLOOR_LEVEL = 175  # of the darkest channel; the white floor between the chips is brighter
COLOURS = ('black', 'grey', 'red', 'brown or yellow')
GREY_SATURATION = 60
BLACK_LEVEL = 75
RED_HUE = 9  # of OpenCV's half degrees, to either side of 0
DIAMETERS = (3.0, 6.0, 12.0, 25.0, 1000.0)
"""Limits of the classes of size, diameter of the disc of equal area [px]."""


@dataclass(frozen=True)
class Chips:
    """Chips of a picture.

    Attributes:
        labels: shape (h, w), the chip that a pixel belongs to, -1 for the floor.
        diameters: shape (n,), of the disc of equal area [px].
        colours: shape (n,), index into ``COLOURS``.
        at_border: shape (n,), whether the picture's border cuts the chip.
    """

    labels: NDArray[np.int32]
    diameters: Array
    colours: NDArray[np.int64]
    at_border: NDArray[np.bool_]


def segment_chips(picture: Image) -> Chips:
    """Return the chips of a blue, green, red picture of coloured chips in a white floor."""
    is_chip = (picture.min(axis=2) < FLOOR_LEVEL).astype(np.uint8)
    is_chip = cv2.morphologyEx(is_chip, cv2.MORPH_OPEN, np.ones((2, 2), dtype=np.uint8))
    count, labels, stats, _ = cv2.connectedComponentsWithStats(is_chip, connectivity=4)
    hue, saturation, value = cv2.split(cv2.cvtColor(picture, cv2.COLOR_BGR2HSV))
    is_red = _means((hue < RED_HUE) | (hue > 180 - RED_HUE), labels, count) > 0.5
    colours = np.where(is_red, 2, 3)
    colours[_means(saturation, labels, count) < GREY_SATURATION] = 1
    colours[_means(value, labels, count) < BLACK_LEVEL] = 0
    left, top, width, height, area = stats.T
    at_border = (
        (left == 0) | (top == 0) | (left + width == labels.shape[1]) | (top + height == labels.shape[0])
    )
    return Chips(labels - 1, np.sqrt(4.0 * area[1:] / np.pi), colours[1:], at_border[1:])


def _means(values: NDArray[Any], labels: NDArray[np.int32], count: int) -> Array:
    flat = labels.ravel()
    return np.bincount(flat, values.ravel().astype(np.float64), count) / np.bincount(flat, minlength=count)


def dots_of_chips(chips: Chips, pixels: Array) -> NDArray[np.int64]:
    """Return how many dots lie on each chip, shape (n,), for dots at u, v, shape (m, 2) [px]."""
    columns, rows = np.round(pixels).astype(int).T
    on_chip = chips.labels[rows, columns]
    return np.bincount(on_chip[on_chip >= 0], minlength=len(chips.diameters))
