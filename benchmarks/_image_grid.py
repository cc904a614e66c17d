"""Example pictures with the dots found and matched drawn in, one by one and side by side."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path

import cv2
import numpy as np
from numpy.typing import NDArray

from floor_localizer.core.fix import Fix, NoFix
from floor_localizer.localization.debug_picture import debug_picture
from shirube_core.files import atomic_write

_ZOOM = 1.25
_STRIP, _GAP, _COLUMNS = 26, 6, 4
_INK, _PAPER = (20, 20, 20), 255


def annotated_image(image: NDArray[np.uint8], result: Fix | NoFix, label: str) -> NDArray[np.uint8]:
    """Return an enlarged image under its label, with its dots: found on the map green, others red."""
    large = cv2.resize(image, None, fx=_ZOOM, fy=_ZOOM, interpolation=cv2.INTER_CUBIC)
    if result.dots is not None:
        dots = replace(
            result.dots,
            pixels=(result.dots.pixels + 0.5) * _ZOOM - 0.5,
            diameters=result.dots.diameters * _ZOOM,
        )
        result = replace(result, dots=dots)
    picture = debug_picture(np.asarray(large, dtype=np.uint8), result)
    strip = np.full((_STRIP, picture.shape[1], 3), _PAPER, dtype=np.uint8)
    cv2.putText(strip, label, (4, _STRIP - 8), cv2.FONT_HERSHEY_SIMPLEX, 0.5, _INK, 1, cv2.LINE_AA)
    return np.vstack([strip, picture])


def image_grid(pictures: Sequence[NDArray[np.uint8]]) -> NDArray[np.uint8]:
    """Return pictures of one size side by side in rows of four."""
    height, width = pictures[0].shape[:2]
    rows = -(-len(pictures) // _COLUMNS)
    columns = min(len(pictures), _COLUMNS)
    grid = np.full(
        (rows * (height + _GAP) + _GAP, columns * (width + _GAP) + _GAP, 3), _PAPER, dtype=np.uint8
    )
    for number, picture in enumerate(pictures):
        row, column = divmod(number, _COLUMNS)
        top, left = _GAP + row * (height + _GAP), _GAP + column * (width + _GAP)
        grid[top : top + height, left : left + width] = picture
    return grid


def write_image(path: Path, picture: NDArray[np.uint8]) -> None:
    """Write a PNG.

    Raises:
        OSError: the place cannot be written to.
    """
    _, data = cv2.imencode('.png', picture, [cv2.IMWRITE_PNG_COMPRESSION, 9])
    with atomic_write(path) as file:
        file.write(data.tobytes())
