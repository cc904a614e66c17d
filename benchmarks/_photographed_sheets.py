"""BoofCV's printed random-dot sheets in photographs (BoofCV-Data, CC BY 4.0): where they are, and views from above.

``photographed_frames.csv`` holds the corners of the sheets' frames in the undistorted images: the printed line in the
photograph, the edge of the card, cut by hand, in the movie. They were found by their edges alone, without the dots,
at the commit 7024b04a (`benchmarks/real_photographs/frame_finder.py`); which sheet it is was found by brute force over
all 120 sheets and four turns, and every sheet followed from image to image by its dots. A sheet is visible if all four
corners are seen and 15 dots or more are uncovered; compared with the eye in 25 frames: no difference.
"""

import csv
import math
from collections.abc import Iterator
from dataclasses import dataclass
from itertools import count
from pathlib import Path

import cv2
import numpy as np
import yaml
from numpy.typing import NDArray

from floor_localizer.core.dots import DotMap
from shirube_core.geometry import SE2, CameraMount, PinholeCamera

Array = NDArray[np.float64]
Image = NDArray[np.uint8]

SHEETS = 'floor_random_dots'
FRAMES = Path(__file__).with_name('photographed_frames.csv')
PHOTOGRAPH = -1  # the number of ``image00.jpg`` among the frames of the movie
CENTIMETRE = 0.01  # [m]
VIEW_CAMERA = PinholeCamera(350, 350, 339.44, 339.44, 174.5, 174.5)
"""The default camera's scale (2.61 px/mm at 130 mm) on a sensor that sees a whole sheet in any heading."""
VIEW_MOUNT = CameraMount()
FLOOR_HALF_WIDTH = 0.0385
"""A sheet is floor within this of its centre [m]; the frame's line, its margin and other sheets are outside."""
BARE_HALF_WIDTH = 0.036
"""Beyond the floor a view shows the brightness of the sheet at this distance, without its dots [m]."""
BARE_WINDOW = 15  # larger than a dot or a line in the photographs [px]
PITCH, COLUMNS = 0.12, 12
DOT_DIAMETER = 0.003

PRINTED_FRAME = 0.04 * np.array([[-1.0, 1.0], [1.0, 1.0], [1.0, -1.0], [-1.0, -1.0]])
"""The printed line round a sheet's dots: a square of ``marker_width`` (80 mm) about the centre [m]."""
CARD_OUTLINES: dict[int, Array] = {
    0: 1e-3 * np.array([[-43.04, 47.89], [43.43, 47.57], [41.87, -47.10], [-44.29, -47.08]]),
    1: 1e-3 * np.array([[-43.61, 47.30], [40.59, 46.60], [40.00, -47.31], [-47.18, -47.26]]),
    3: 1e-3 * np.array([[-44.41, 46.61], [43.01, 46.59], [42.49, -52.93], [-44.19, -52.43]]),
    7: 1e-3 * np.array([[-46.77, 48.46], [39.49, 48.49], [41.72, -47.81], [-47.47, -47.73]]),
}
"""The cards of the movie: their corners on the sheet [m], clockwise from the upper left one, x right and y up.

Measured in every tenth frame of the movie, from the found corners and the homography of the dots, as the median.
"""
MEASURED_EVERY = 10
"""Frames of the movie whose numbers this divides were used to measure the cards; they are left out of trials."""


@dataclass(frozen=True)
class SheetView:
    """A sheet in an image.

    Attributes:
        number: index of the movie's frame, or ``PHOTOGRAPH``.
        sheet: which sheet it is.
        is_visible: whether its corners and 15 dots are.
        image: grey, undistorted.
        corners: shape (4, 2), of its frame in the image, from the upper left one on, clockwise on the sheet [px].
    """

    number: int
    sheet: int
    is_visible: bool
    image: Image
    corners: Array

    def from_above(self, T_sheet_base: SE2) -> Image:
        """Return what a camera straight above the sheet would see, the robot at a pose on it.

        Beyond the floor that the sheet is, its brightness without dots is continued: nothing else is in view.
        """
        frame = PRINTED_FRAME if self.number == PHOTOGRAPH else CARD_OUTLINES[self.sheet]
        homography = cv2.getPerspectiveTransform(frame.astype(np.float32), self.corners.astype(np.float32))
        columns, rows = np.meshgrid(np.arange(VIEW_CAMERA.width), np.arange(VIEW_CAMERA.height))
        rays = VIEW_CAMERA.rays_from_pixels(np.column_stack([columns.ravel(), rows.ravel()]))
        points = T_sheet_base.transform(VIEW_MOUNT.floor_points_from_rays(rays))
        on_floor = np.clip(points, -FLOOR_HALF_WIDTH, FLOOR_HALF_WIDTH)
        window = np.ones((BARE_WINDOW, BARE_WINDOW), dtype=np.uint8)
        bare = np.asarray(cv2.morphologyEx(self.image, cv2.MORPH_CLOSE, window), dtype=np.uint8)
        floor = _sample(self.image, homography, on_floor)
        beyond = _sample(bare, homography, np.clip(points, -BARE_HALF_WIDTH, BARE_HALF_WIDTH))
        view = np.where((points == on_floor).all(axis=1), floor, beyond)
        return view.reshape(VIEW_CAMERA.height, VIEW_CAMERA.width)


def _sample(image: Image, homography: Array, points: Array) -> Image:
    """Return the image at points of the sheet, shape (n, 2) [m] to (n,)."""
    pixels = cv2.perspectiveTransform(points[None], homography).astype(np.float32)
    # In rows, for OpenCV remaps to at most 32767 columns.
    u, v = np.moveaxis(pixels.reshape(VIEW_CAMERA.height, -1, 2), 2, 0)
    levels = cv2.remap(image, u, v, cv2.INTER_CUBIC, borderMode=cv2.BORDER_REPLICATE)
    return np.asarray(levels.ravel(), dtype=np.uint8)


def random_view_pose(generator: np.random.Generator) -> SE2:
    """Return a pose of the robot on a sheet: any heading, the camera within 5 mm of its centre."""
    x, y = generator.uniform(-0.005, 0.005, 2)
    return SE2(x, y, generator.uniform(-math.pi, math.pi))


def load_sheets(folder: Path) -> list[Array]:
    """Return the dots of the 120 sheets, each of shape (30, 2) [m], x to the right and y up on the printed sheet.

    The file counts centimetres from the centre with y down the sheet, as the photographs show.
    """
    description = yaml.load((folder / 'descriptions.yaml').read_text(), Loader=yaml.CSafeLoader)
    return [np.array(marker) * (CENTIMETRE, -CENTIMETRE) for marker in description['markers']]


def sheet_origin(sheet: int) -> Array:
    """Return the position of a sheet's centre in the map of all sheets, shape (2,) [m]."""
    return PITCH * np.array([sheet % COLUMNS, sheet // COLUMNS], dtype=np.float64)


def sheet_map(sheets: list[Array], left_out: int | None = None) -> DotMap:
    """Return the map of all sheets side by side, upright, in rows of 12; one may be left out."""
    points = np.concatenate([dots + sheet_origin(k) for k, dots in enumerate(sheets) if k != left_out])
    return DotMap(points, np.full(len(points), DOT_DIAMETER))


def sheet_views(folder: Path, every: int = 1) -> Iterator[SheetView]:
    """Yield the sheets of the photograph, then those of every so-many-th frame of the movie."""
    known: dict[int, list[tuple[int, bool, Array]]] = {}
    with FRAMES.open() as file:
        for row in list(csv.reader(file))[1:]:
            place = np.array(row[3:], dtype=np.float64).reshape(4, 2)
            known.setdefault(int(row[0]), []).append((int(row[1]), row[2] == '1', place))
    for number, image in _images(folder, every):
        for sheet, is_visible, corners in known.get(number, []):
            yield SheetView(number, sheet, is_visible, image, corners)


def _images(folder: Path, every: int) -> Iterator[tuple[int, Image]]:
    """Yield number and image, grey and undistorted."""
    image = np.asarray(cv2.imread(str(folder / 'image00.jpg'), cv2.IMREAD_GRAYSCALE), dtype=np.uint8)
    yield PHOTOGRAPH, _undistorted(image, _camera(folder / 'intrinsic.yaml'))
    camera, movie = _camera(folder / 'movie_intrinsic.yaml'), cv2.VideoCapture(str(folder / 'movie.mp4'))
    for number in count():
        there, frame = movie.read()
        if not there:
            break
        if number % every == 0:
            grey = np.asarray(cv2.cvtColor(frame, cv2.COLOR_BGR2GRAY), dtype=np.uint8)
            yield number, _undistorted(grey, camera)
    movie.release()


def _camera(path: Path) -> PinholeCamera:
    """Return the camera of one of BoofCV's intrinsics files."""
    intrinsics = yaml.safe_load(path.read_text())
    pinhole, lens = intrinsics['pinhole'], intrinsics['radial_tangential']
    sizes = {key: pinhole[key] for key in ('width', 'height', 'fx', 'fy', 'cx', 'cy')}
    return PinholeCamera(**sizes, distortion=(*lens['radial'], lens['t1'], lens['t2'], 0.0))


def _undistorted(image: Image, camera: PinholeCamera) -> Image:
    return np.asarray(cv2.undistort(image, camera.matrix, np.array(camera.distortion)), dtype=np.uint8)
