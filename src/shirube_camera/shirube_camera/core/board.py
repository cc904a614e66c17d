"""Calibration boards, chessboard or ChArUco: corners on the board, and their detection in images."""

from dataclasses import dataclass
from typing import Any, NamedTuple

import cv2
import numpy as np
from numpy.typing import NDArray

from shirube_core.settings import setting

Array = NDArray[np.float64]

MARKER = 0.75
"""Side of a ChArUco marker, of the dictionary DICT_4X4_1000, relative to that of a square."""
_CORNERS_MIN = 12  # of a partly visible ChArUco board
_WINDOW = 0.25  # half width of the refinement window, relative to the distance of corners
_TERMINATION = (cv2.TERM_CRITERIA_EPS | cv2.TERM_CRITERIA_COUNT, 30, 1e-3)


class ShirubeCameraError(ValueError):
    """A camera, a file or the views of a board do not allow what is asked; the text is one line with the remedy."""


@dataclass(frozen=True)
class BoardSettings:
    """The calibration board; its size is counted in inner corners."""

    pattern: str = setting('chessboard', 'kind of board', choices=('chessboard', 'charuco'))
    columns: int = setting(9, 'inner corners in a row of the board', limits=(3, 30))
    rows: int = setting(6, 'inner corners in a column of the board', limits=(3, 30))
    square: float = setting(0.025, 'side of a square, measured on paper', 'm', (1e-3, 1.0))


class BoardView(NamedTuple):
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
        self._charuco: Any = None
        if settings.pattern == 'charuco':
            aruco: Any = getattr(cv2, 'aruco', None)  # OpenCV 4.6 may lack it
            if not hasattr(aruco, 'CharucoDetector'):
                raise ShirubeCameraError(
                    f'OpenCV {cv2.__version__} has no ChArUco detector; use a chessboard, or OpenCV 4.7 or newer'
                )
            words = aruco.getPredefinedDictionary(aruco.DICT_4X4_1000)
            squares, side = (settings.columns + 1, settings.rows + 1), settings.square
            self._charuco = aruco.CharucoDetector(aruco.CharucoBoard(squares, side, MARKER * side, words))

    def detect(self, image: NDArray[np.uint8]) -> BoardView | None:
        """Return the corners in a grey image, shape (h, w), or None if the board is not found."""
        if self._charuco is not None:
            corners, ids, _, _ = self._charuco.detectBoard(image)
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
