"""One view of the floor while it is painted, from the ground upwards, with exact area coverage of every pixel."""

import math
from collections.abc import Sequence
from functools import cached_property

import numpy as np
from numba import njit
from numpy.typing import ArrayLike, NDArray

from scene_simulator.floor.dot_floor import FloorMarks
from scene_simulator.imaging.sensors import clip_integral
from shirube_core.geometry import SE2, CameraMount, PinholeCamera

GREY_FROM_BGR = np.array([[0.114], [0.587], [0.299]])
"""Weights of blue, green and red in a mono camera's grey (ITU-R BT.601)."""

MAX_GLARE = 0.5  # glare above which a dark chip is indistinguishable from a light floor


def paint_polygons(
    layer: NDArray[np.float32],
    covered: NDArray[np.float32],
    corners: NDArray[np.float64],
    colours: NDArray[np.float64],
    opacities: NDArray[np.float64],
) -> None:
    """Paint polygons over a picture, one after the other.

    A pixel that a polygon covers by the fraction a becomes ``(1 - a * opacity) * pixel + a * opacity * colour``.

    Args:
        layer: shape (height, width, channels), the picture, changed in place.
        covered: shape (height, width), fraction of each pixel that is hidden, changed in place in the same way.
        corners: shape (n, v, 2), u and v [px], origin in the centre of the upper left pixel.
        colours: shape (n, channels).
        opacities: shape (n,), 0 to 1.
    """
    if len(corners):
        _paint(layer, covered, corners + 0.5, colours, opacities)


@njit(cache=True)
def _paint(
    layer: NDArray[np.float32],
    covered: NDArray[np.float32],
    corners: NDArray[np.float64],
    colours: NDArray[np.float64],
    opacities: NDArray[np.float64],
) -> None:
    height, width, channels = layer.shape
    for k in range(len(corners)):
        polygon = corners[k]
        left = max(0, math.floor(polygon[:, 0].min()))
        right = min(width, math.ceil(polygon[:, 0].max()))
        top = max(0, math.floor(polygon[:, 1].min()))
        bottom = min(height, math.ceil(polygon[:, 1].max()))
        if left >= right or top >= bottom:
            continue
        coverage = _coverage(polygon, left, right, top, bottom)
        for row in range(top, bottom):
            for column in range(left, right):
                alpha = min(abs(coverage[row - top, column - left]), 1.0) * opacities[k]
                covered[row, column] += (1.0 - covered[row, column]) * alpha
                for channel in range(channels):
                    pixel = layer[row, column, channel]
                    layer[row, column, channel] = pixel + alpha * (colours[k, channel] - pixel)


@njit(cache=True)
def _coverage(polygon: NDArray[np.float64], left: int, right: int, top: int, bottom: int) -> NDArray[np.float64]:
    """Return the signed fraction of each pixel of a window that is inside a polygon.

    The area right of an edge within a pixel is the integral over the edge's rise of the part of the pixel's
    width that is right of the edge; summed with sign over all edges it is the polygon's area in the pixel.
    """
    coverage = np.zeros((bottom - top, right - left))
    for i in range(len(polygon)):
        x0, y0 = polygon[i - 1]
        x1, y1 = polygon[i]
        if y0 == y1:
            continue
        slope = (x1 - x0) / (y1 - y0)
        low, high = max(min(y0, y1), top), min(max(y0, y1), bottom)
        sign = 1.0 if y1 > y0 else -1.0
        for row in range(math.floor(low), math.ceil(high)):
            enter, leave = max(low, row), min(high, row + 1)
            xa, xb = x0 + slope * (enter - y0), x0 + slope * (leave - y0)
            for column in range(max(left, math.floor(min(xa, xb))), right):
                width = _mean_width(column + 1.0 - xa, column + 1.0 - xb)
                coverage[row - top, column - left] += sign * width * (leave - enter)
    return coverage


@njit(cache=True)
def _mean_width(a: float, b: float) -> float:
    """Return the mean of clip(t, 0, 1) for t between a and b."""
    if abs(a - b) < 1e-9:
        return min(max(0.5 * (a + b), 0.0), 1.0)
    return (clip_integral(a) - clip_integral(b)) / (a - b)


class FloorView:
    """What a camera sees of a floor during one exposure.

    The exposure is a series of instants with a robot pose each. Polygons are painted at each instant, so
    motion smears them as it does in a camera; broad, soft things are painted at the middle instant only.

    Attributes:
        layers: shape (instants, height, width, channels), reflectance, blue-green-red or grey.
        covered: shape (instants, height, width), fraction of each pixel that dirt hides.
        glare: shape (height, width), light that does not come from the floor, 1 saturates.
    """

    def __init__(
        self,
        camera: PinholeCamera,
        mount: CameraMount,
        poses: Sequence[SE2],
        rays: NDArray[np.float64],
        *,
        colour: bool,
    ) -> None:
        """Start with a black floor, seen by rays, shape (height * width, 3), from ``T_map_base`` at each instant."""
        shape = (len(poses), camera.height, camera.width)
        self.layers = np.zeros((*shape, 3 if colour else 1), dtype=np.float32)
        self.covered = np.zeros(shape, dtype=np.float32)
        self.glare = np.zeros(shape[1:], dtype=np.float32)
        self._camera, self._mount, self._poses, self._rays = camera, mount, poses, rays

    @cached_property
    def floor_points(self) -> NDArray[np.float64]:
        """Floor point of each pixel at the middle instant, in the map frame, shape (height, width, 2) [m]."""
        points = self._mount.floor_points_from_rays(self._rays)
        middle = self._poses[len(self._poses) // 2]
        return middle.transform(points).reshape(self._camera.height, self._camera.width, 2)

    @cached_property
    def centre(self) -> NDArray[np.float64]:
        """Floor point in the middle of the view, in the map frame, shape (2,) [m]."""
        return np.asarray(self.floor_points[self._camera.height // 2, self._camera.width // 2])

    @cached_property
    def reach(self) -> float:
        """Radius of a disc about the centre that holds the view [m]."""
        corners = self.floor_points[[0, 0, -1, -1], [0, -1, 0, -1]]
        return float(np.hypot(*(corners - self.centre).T).max())

    @cached_property
    def pixel_size(self) -> float:
        """Width of a pixel on the floor in the middle of the view [m]."""
        row, column = self._camera.height // 2, self._camera.width // 2
        return float(np.hypot(*(self.floor_points[row, column] - self.floor_points[row, column - 1])))

    def channels(self, colours: ArrayLike) -> NDArray[np.float64]:
        """Return colours (blue, green, red), shape (n, 3), as this view's channels, shape (n, channels)."""
        bgr = np.asarray(colours, dtype=np.float64)
        return bgr if self.layers.shape[-1] == 3 else bgr @ GREY_FROM_BGR

    def paint(self, marks: FloorMarks, *, dirt: bool) -> None:
        """Paint the marks that are in view over what is there; as dirt they count as hidden floor."""
        seen = marks.select(marks.near(self.centre, self.reach))
        colours, corners = self.channels(seen.colours), seen.corners()
        for layer, covered, pose in zip(self.layers, self.covered, self._poses, strict=True):
            pixels = self._project(pose, corners.reshape(-1, 2)).reshape(corners.shape)
            hidden = covered if dirt else np.zeros_like(covered)
            paint_polygons(layer, hidden, pixels, colours, seen.opacities)

    def blend(self, fraction: NDArray[np.floating], colour: ArrayLike, *, dirt: bool) -> None:
        """Blend a colour over the view.

        Args:
            fraction: shape (height, width), opacity of the colour at each pixel, 0 to 1.
            colour: array-like, shape (3,), reflectance in blue, green and red.
            dirt: whether it counts as hidden floor.
        """
        alpha = fraction.astype(np.float32)
        colours = self.channels(np.reshape(colour, (1, 3))).astype(np.float32)
        self.layers += alpha[None, :, :, None] * (colours - self.layers)
        if dirt:
            self.covered += alpha * (1.0 - self.covered)

    def add_glare(self, light: NDArray[np.floating]) -> None:
        """Add light that is not the floor's, shape (height, width); above ``MAX_GLARE`` it hides the floor."""
        self.glare += light.astype(np.float32)
        self.covered += (light > MAX_GLARE) * (1.0 - self.covered)

    def _project(self, pose: SE2, points: NDArray[np.float64]) -> NDArray[np.float64]:
        """Return the pixels of map points, shape (n, 2), seen by the robot at ``pose`` (``T_map_base``)."""
        points_base = pose.inverse().transform(points)
        return self._camera.pixels_from_points(self._mount.camera_points_from_floor(points_base))
