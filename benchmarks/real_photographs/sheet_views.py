"""Views of little floors, made of the sheets in photographs by way of their frames."""

from __future__ import annotations

import math
from typing import Any

import cv2
import numpy as np
from numpy.typing import NDArray

from floor_localizer.core.dot_map import DotMap
from shirube_geometry import CameraMount, PinholeCamera, PlanarPose

Array = NDArray[np.float64]
Image = NDArray[np.uint8]

VIEW_CAMERA = PinholeCamera(350, 350, 339.44, 339.44, 174.5, 174.5)
"""The default camera's scale (2.61 px/mm at 130 mm) on a sensor that sees a whole sheet in any heading."""

VIEW_MOUNT = CameraMount()
FLOOR_HALF_WIDTH = 0.0385
"""A sheet is floor within this of its centre [m]; the frame's line, its margin and other sheets are outside."""

BARE_HALF_WIDTH = 0.036
"""Beyond the floor a view shows the brightness of the sheet at this distance, without its dots [m]."""

BARE_WINDOW = 15  # larger than a dot or a line in the photographs [px]
PITCH = 0.12
COLUMNS = 12
DOT_DIAMETER = 0.003


def sheet_place(sheet: int) -> Array:
    """Return where a sheet's centre lies in the map of all sheets, shape (2,) [m]."""
    return PITCH * np.array([sheet % COLUMNS, sheet // COLUMNS], dtype=np.float64)


def sheet_map(sheets: list[Array], left_out: int | None = None) -> DotMap:
    """Return the map of all sheets side by side, upright, in rows of 12; one sheet may be left out."""
    points = np.concatenate(
        [sheet + sheet_place(index) for index, sheet in enumerate(sheets) if index != left_out]
    )
    return DotMap(points, np.full(len(points), DOT_DIAMETER))


def random_view_pose(generator: np.random.Generator) -> PlanarPose:
    """Return a pose of the robot on a sheet: any heading, the camera within 5 mm of the sheet's centre."""
    x, y = generator.uniform(-0.005, 0.005, 2)
    return PlanarPose(x, y, generator.uniform(-math.pi, math.pi))


def sheet_view(image: Image, corners: Array, frame: Array, T_sheet_base: PlanarPose) -> Image:
    """Return what a camera straight above a sheet would see of it.

    Beyond the floor that the sheet is, its brightness without dots is continued: nothing else is in view.

    Args:
        image: grey, undistorted.
        corners: shape (4, 2), of the sheet's frame in the image [px].
        frame: shape (4, 2), the same corners on the sheet [m].
        T_sheet_base: the robot's pose on the sheet.
    """
    homography = cv2.getPerspectiveTransform(frame.astype(np.float32), corners.astype(np.float32))
    columns, rows = np.meshgrid(np.arange(VIEW_CAMERA.width), np.arange(VIEW_CAMERA.height))
    rays = VIEW_CAMERA.rays_from_pixels(np.column_stack([columns.ravel(), rows.ravel()]))
    points = T_sheet_base.transform(VIEW_MOUNT.floor_points_from_rays(rays))
    on_floor = np.clip(points, -FLOOR_HALF_WIDTH, FLOOR_HALF_WIDTH)
    bare = cv2.morphologyEx(image, cv2.MORPH_CLOSE, np.ones((BARE_WINDOW, BARE_WINDOW), dtype=np.uint8))
    floor = _sampled(image, homography, on_floor)
    beyond = _sampled(bare, homography, np.clip(points, -BARE_HALF_WIDTH, BARE_HALF_WIDTH))
    view = np.where((points == on_floor).all(axis=1), floor, beyond)
    return view.reshape(VIEW_CAMERA.height, VIEW_CAMERA.width)


def _sampled(image: Image, homography: NDArray[np.floating[Any]], points: Array) -> Image:
    """Return the image at points of the sheet, shape (n, 2) [m] to (n,)."""
    pixels = cv2.perspectiveTransform(points[None], homography).astype(np.float32)
    # In rows, for OpenCV remaps to at most 32767 columns.
    u, v = np.moveaxis(pixels.reshape(VIEW_CAMERA.height, -1, 2), 2, 0)
    levels = cv2.remap(image, u, v, cv2.INTER_CUBIC, borderMode=cv2.BORDER_REPLICATE)
    return np.asarray(levels.ravel(), dtype=np.uint8)
