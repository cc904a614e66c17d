"""Views of little floors, made of the pages in photographs by way of their frames."""

from __future__ import annotations

import math
from typing import Any

import cv2
import numpy as np
from numpy.typing import NDArray

from floor_localizer.core.dots import DotMap
from shirube_core.geometry import SE2, CameraMount, PinholeCamera

Array = NDArray[np.float64]
Image = NDArray[np.uint8]

VIEW_CAMERA = PinholeCamera(350, 350, 339.44, 339.44, 174.5, 174.5)
"""The default camera's scale (2.61 px/mm at 130 mm) on a sensor that sees a whole page in any heading."""

VIEW_MOUNT = CameraMount()
FLOOR_HALF_WIDTH = 0.0385
"""A page is floor within this of its centre [m]; the frame's line, its margin and other pages are outside."""

BARE_HALF_WIDTH = 0.036
"""Beyond the floor a view shows the brightness of the page at this distance, without its dots [m]."""

BARE_WINDOW = 15  # larger than a dot or a line in the photographs [px]
PITCH = 0.12
COLUMNS = 12
DOT_DIAMETER = 0.003


def page_origin(page: int) -> Array:
    """Return the position of a page's centre in the map of all pages, shape (2,) [m]."""
    return PITCH * np.array([page % COLUMNS, page // COLUMNS], dtype=np.float64)


def page_map(pages: list[Array], left_out: int | None = None) -> DotMap:
    """Return the map of all pages side by side, upright, in rows of 12; one page may be left out."""
    points = np.concatenate(
        [page + page_origin(index) for index, page in enumerate(pages) if index != left_out]
    )
    return DotMap(points, np.full(len(points), DOT_DIAMETER))


def random_view_pose(generator: np.random.Generator) -> SE2:
    """Return a pose of the robot on a page: any heading, the camera within 5 mm of the page's centre."""
    x, y = generator.uniform(-0.005, 0.005, 2)
    return SE2(x, y, generator.uniform(-math.pi, math.pi))


def page_view(image: Image, corners: Array, frame: Array, T_page_base: SE2) -> Image:
    """Return what a camera straight above a page would see of it.

    Beyond the floor that the page is, its brightness without dots is continued: nothing else is in view.

    Args:
        image: grey, undistorted.
        corners: shape (4, 2), of the page's frame in the image [px].
        frame: shape (4, 2), the same corners on the page [m].
        T_page_base: the robot's pose on the page.
    """
    homography = cv2.getPerspectiveTransform(frame.astype(np.float32), corners.astype(np.float32))
    columns, rows = np.meshgrid(np.arange(VIEW_CAMERA.width), np.arange(VIEW_CAMERA.height))
    rays = VIEW_CAMERA.rays_from_pixels(np.column_stack([columns.ravel(), rows.ravel()]))
    points = T_page_base.transform(VIEW_MOUNT.floor_points_from_rays(rays))
    on_floor = np.clip(points, -FLOOR_HALF_WIDTH, FLOOR_HALF_WIDTH)
    bare = cv2.morphologyEx(image, cv2.MORPH_CLOSE, np.ones((BARE_WINDOW, BARE_WINDOW), dtype=np.uint8))
    floor = _sample(image, homography, on_floor)
    beyond = _sample(bare, homography, np.clip(points, -BARE_HALF_WIDTH, BARE_HALF_WIDTH))
    view = np.where((points == on_floor).all(axis=1), floor, beyond)
    return view.reshape(VIEW_CAMERA.height, VIEW_CAMERA.width)


def _sample(image: Image, homography: NDArray[np.floating[Any]], points: Array) -> Image:
    """Return the image at points of the page, shape (n, 2) [m] to (n,)."""
    pixels = cv2.perspectiveTransform(points[None], homography).astype(np.float32)
    # In rows, for OpenCV remaps to at most 32767 columns.
    u, v = np.moveaxis(pixels.reshape(VIEW_CAMERA.height, -1, 2), 2, 0)
    levels = cv2.remap(image, u, v, cv2.INTER_CUBIC, borderMode=cv2.BORDER_REPLICATE)
    return np.asarray(levels.ravel(), dtype=np.uint8)
