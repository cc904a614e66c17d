"""Calibration boards, chessboard or ChArUco: corners on the board, detection in images, and the printed pattern."""

from __future__ import annotations

from dataclasses import dataclass

import cv2
import numpy as np
from numpy.typing import NDArray

from shirube_core.settings import setting

Array = NDArray[np.float64]

MODULES = 8
"""Modules along a square of the printed pattern; a marker of 4 x 4 bits has 6 with its border."""
_CORNERS_MIN = 12  # of a partly visible ChArUco board
_WINDOW = 0.25  # half width of the refinement window, relative to the distance of corners
_TERMINATION = (cv2.TERM_CRITERIA_EPS | cv2.TERM_CRITERIA_COUNT, 30, 1e-3)


class ShirubeCameraError(ValueError):
    """A camera, a file or the views of a board do not allow what is asked; the text is one line with the remedy."""


@dataclass(frozen=True)
class BoardSettings:
    """The calibration board; its size is counted in inner corners."""

    pattern: str = setting(
        'chessboard', 'all of a chessboard must be visible', choices=('chessboard', 'charuco')
    )
    columns: int = setting(9, 'inner corners in a row of the board', minimum=3, maximum=30)
    rows: int = setting(6, 'inner corners in a column of the board', minimum=3, maximum=30)
    square: float = setting(0.025, 'side of a square, measured on paper', unit='m', minimum=1e-3, maximum=1.0)


@dataclass(frozen=True, eq=False)
class BoardView:
    """Indices of the detected corners on the board, shape (n,), ascending, and their pixels, shape (n, 2)."""

    ids: NDArray[np.int64]
    pixels: Array


class Board:
    """A calibration board; ``corners`` are its inner corners, row by row [m], shape (n, 3), with z = 0."""

    def __init__(self, settings: BoardSettings) -> None:
        """Prepare the detection; raise a ShirubeCameraError if this OpenCV has no ChArUco."""
        self.size = settings.columns, settings.rows
        x, y = np.meshgrid(*map(np.arange, self.size))
        self.corners = settings.square * np.stack([x.ravel(), y.ravel(), 0 * x.ravel()], axis=-1, dtype=float)
        self._is_charuco = settings.pattern == 'charuco'
        if self._is_charuco:
            if not hasattr(getattr(cv2, 'aruco', None), 'CharucoDetector'):
                raise ShirubeCameraError(
                    f'OpenCV {cv2.__version__} has no ChArUco detector; use a chessboard, or OpenCV 4.7 or newer'
                )
            squares, marker = (
                (settings.columns + 1, settings.rows + 1),
                (MODULES - 2) / MODULES * settings.square,
            )
            words = cv2.aruco.getPredefinedDictionary(cv2.aruco.DICT_4X4_1000)
            self._charuco = cv2.aruco.CharucoBoard(squares, settings.square, marker, words)
            self._detector = cv2.aruco.CharucoDetector(self._charuco)

    def detect(self, image: NDArray[np.uint8]) -> BoardView | None:
        """Return the corners in a grey image, shape (h, w), or None if the board is not found."""
        if self._is_charuco:
            corners, ids, _, _ = self._detector.detectBoard(image)
            if ids is None or len(ids) < _CORNERS_MIN:
                return None
            order = np.argsort(ids.ravel())
            return BoardView(ids.ravel()[order], np.asarray(corners, np.float64).reshape(-1, 2)[order])
        is_found, corners = cv2.findChessboardCornersSB(image, self.size, flags=0)
        if not is_found:
            return None
        # The positions of this detector are biased in real images: they made a focal length of 518 px one of 526 px.
        grid = corners.reshape(*self.size[::-1], 2)
        step = min(np.linalg.norm(np.diff(grid, axis=axis), axis=-1).min() for axis in (0, 1))
        half = int(np.clip(_WINDOW * step, 2, 11))
        refined = cv2.cornerSubPix(image, corners.reshape(-1, 1, 2), (half, half), (-1, -1), _TERMINATION)
        return BoardView(np.arange(len(self.corners)), np.asarray(refined, np.float64).reshape(-1, 2))

    def modules(self) -> NDArray[np.bool_]:
        """Return which modules of the printed pattern are black; a square has `MODULES` x `MODULES`."""
        width, height = (MODULES * (count + 1) for count in self.size)
        if self._is_charuco:
            return np.asarray(self._charuco.generateImage((width, height)) == 0)
        y, x = np.mgrid[:height, :width] // MODULES
        return np.asarray((x + y) % 2 == 0)
