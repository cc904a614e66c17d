"""A corridor: objects in back-to-front order, people and boards before them, and the true landmark positions."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, field, replace
from functools import cached_property
from typing import Any, Protocol, cast

import numpy as np
from numba import njit
from numpy.typing import NDArray

from scene_simulator.corridor.drawing import WallObject
from scene_simulator.corridor.shapes import CorridorLight, FlatShape, Landmark, Paint, ShapeTable, Surface, shape_table
from scene_simulator.errors import SceneError

NEAR = 0.05  # near clipping distance [m]
_MAX_CHORD = 6.0  # longest chord of an outline behind a distorting lens [px]: it is off by 0.002 px


@njit(cache=True, error_model='numpy')
def project_outline(
    points: NDArray[np.float64],
    planes: NDArray[np.float64],
    lens: NDArray[np.float64],
    size: tuple[int, int],
    scale: float,
) -> NDArray[np.float64]:
    """Return the part of an outline that is in the picture, shape (n, 2), n = 0 where nothing is.

    Args:
        points: shape (n, 3), the outline in the optical frame [m].
        planes: shape (m, 4), half spaces that hold the view, see ``view_planes``.
        lens: fx, fy, cx, cy, k1, k2, p1, p2, k3 of the picture.
        size: width and height of the picture [px].
        scale: samples per pixel along each side.

    Returns:
        corners in samples; the picture's upper left corner is the origin, not its first sample's centre.
    """
    seen = points
    for plane in planes:
        seen = _clip_to_half_space(seen, plane)
        if len(seen) < 3:
            return np.empty((0, 2))
    flat = _project(seen, lens)
    picture = np.empty((len(flat), 3))
    for k in range(len(flat)):
        picture[k, 0], picture[k, 1] = scale * (flat[k, 0] + 0.5), scale * (flat[k, 1] + 0.5)
        picture[k, 2] = 1.0
    width, height = float(scale * size[0]), float(scale * size[1])
    borders = np.array([[1.0, 0.0, 0.0, 0.0], [-1.0, 0.0, width, 0.0], [0.0, 1.0, 0.0, 0.0], [0.0, -1.0, height, 0.0]])
    for border in borders:
        picture = _clip_to_half_space(picture, border)
        if len(picture) < 3:
            return np.empty((0, 2))
    corners = np.empty((len(picture), 2))
    for k in range(len(picture)):
        corners[k, 0] = min(max(picture[k, 0], 0.0), width)
        corners[k, 1] = min(max(picture[k, 1], 0.0), height)
    return corners


def view_planes(rays: NDArray[np.float64]) -> NDArray[np.float64]:
    """Return the half spaces that hold all that a camera sees, and little more, shape (5, 4).

    A row (a, b, c, d) is the half space ``a x + b y + c z + d >= 0`` of the optical frame.

    Args:
        rays: shape (height, width, 2), the undistorted rays of the samples, z = 1.
    """
    low, high = rays.reshape(-1, 2).min(axis=0), rays.reshape(-1, 2).max(axis=0)
    margin = 0.02 * (high - low)
    (left, top), (right, bottom) = low - margin, high + margin
    rows = [(0, 0, 1, -NEAR), (1, 0, -left, 0), (-1, 0, right, 0), (0, 1, -top, 0), (0, -1, bottom, 0)]
    return np.array(rows, dtype=np.float64)


@njit(cache=True, error_model='numpy')
def _clip_to_half_space(points: NDArray[np.float64], plane: NDArray[np.float64]) -> NDArray[np.float64]:
    """Return the part of an outline in a half space (Sutherland and Hodgman), shape (m, 3)."""
    n = len(points)
    heights = np.empty(n)
    inside = 0
    for i in range(n):
        x, y, z = points[i]
        heights[i] = plane[0] * x + plane[1] * y + plane[2] * z + plane[3]
        if heights[i] >= 0.0:
            inside += 1
    if inside == n:
        return points
    kept = np.empty((2 * n, 3))
    count = 0
    for i in range(n):
        before, here = heights[i - 1], heights[i]
        if (before >= 0.0) != (here >= 0.0):
            for k in range(3):
                kept[count, k] = points[i - 1, k] + before / (before - here) * (points[i, k] - points[i - 1, k])
            count += 1
        if here >= 0.0:
            for k in range(3):
                kept[count, k] = points[i, k]
            count += 1
    return kept[:count]


@njit(cache=True, error_model='numpy')
def _project(points: NDArray[np.float64], lens: NDArray[np.float64]) -> NDArray[np.float64]:
    """Return the picture of an outline, shape (m, 2) [px]; its sides are bent where the lens distorts."""
    n = len(points)
    chord_counts = np.ones(n, dtype=np.int64)
    if np.any(lens[4:] != 0.0):
        for i in range(n):
            dx = points[i, 0] / points[i, 2] - points[i - 1, 0] / points[i - 1, 2]
            dy = points[i, 1] / points[i, 2] - points[i - 1, 1] / points[i - 1, 2]
            chord_counts[i] = max(1, math.ceil(math.hypot(lens[0] * dx, lens[1] * dy) / _MAX_CHORD))
    flat = np.empty((chord_counts.sum(), 2))
    count = 0
    for i in range(n):
        x0, y0 = points[i - 1, 0] / points[i - 1, 2], points[i - 1, 1] / points[i - 1, 2]
        x1, y1 = points[i, 0] / points[i, 2], points[i, 1] / points[i, 2]
        for k in range(1, chord_counts[i] + 1):
            fraction = k / chord_counts[i]
            place = _distort(x0 + fraction * (x1 - x0), y0 + fraction * (y1 - y0), lens)
            flat[count, 0], flat[count, 1] = place
            count += 1
    return flat


@njit(cache=True, error_model='numpy')
def _distort(x: float, y: float, lens: NDArray[np.float64]) -> tuple[float, float]:
    """Return the pixel of a ray (x, y, 1) behind a ``plumb_bob`` lens."""
    k1, k2, p1, p2, k3 = lens[4], lens[5], lens[6], lens[7], lens[8]
    r2 = x * x + y * y
    radial = 1.0 + r2 * (k1 + r2 * (k2 + r2 * k3))
    xd = x * radial + 2.0 * p1 * x * y + p2 * (r2 + 2.0 * x * x)
    yd = y * radial + p1 * (r2 + 2.0 * y * y) + 2.0 * p2 * x * y
    return lens[0] * xd + lens[2], lens[1] * yd + lens[3]


@dataclass(frozen=True)
class Person(WallObject):
    """A person of a height [m] cut out of an upright plane; greys of jacket, trousers and helmet."""

    height: float = 1.75
    greys: tuple[float, float, float] = (0.35, 0.2, 0.8)

    def shapes(self) -> list[FlatShape]:
        """Return the painted shapes, bottom first."""
        drawing, h = self._drawing(), self.height
        jacket, trousers, helmet = self.greys
        for side in (-1.0, 1.0):
            leg = [(0.01, 0.5), (0.095, 0.5), (0.075, 0.03), (0.025, 0.03)]
            drawing.polygon(h * np.array(leg) * (side, 1.0), Paint(trousers, 0.06))
            left, right = sorted((side * 0.02 * h, side * 0.1 * h))
            drawing.rectangle((left, 0.0), (right, 0.035 * h), Paint(0.08))
            arm = [(0.115, 0.81), (0.155, 0.76), (0.165, 0.47), (0.125, 0.47), (0.11, 0.7)]
            drawing.polygon(h * np.array(arm) * (side, 1.0), Paint(0.85 * jacket, 0.06))
            drawing.disc((side * 0.145 * h, 0.455 * h), 0.024 * h, Paint(0.6))
        half = [(-0.1, 0.46), (-0.095, 0.7), (-0.125, 0.81), (-0.03, 0.845)]
        torso = [*half, *((-x, y) for x, y in reversed(half))]
        drawing.polygon(h * np.array(torso), Paint(jacket, 0.06))
        drawing.stroke([(0.0, 0.47 * h), (0.0, 0.83 * h)], 0.006, Paint(0.5 * jacket))
        for band in (0.56, 0.68):
            drawing.rectangle((-0.098 * h, band * h), (0.098 * h, (band + 0.025) * h), Paint(0.9))
        drawing.rectangle((-0.025 * h, 0.83 * h), (0.025 * h, 0.88 * h), Paint(0.55))
        drawing.disc((0.0, 0.915 * h), 0.058 * h, Paint(0.62))
        angles = np.linspace(0.0, np.pi, 24)
        dome = np.column_stack([0.066 * np.cos(angles), 0.935 + 0.065 * np.sin(angles)])
        drawing.polygon(h * dome, Paint(helmet))
        drawing.rectangle((-0.078 * h, 0.93 * h), (0.078 * h, 0.94 * h), Paint(0.8 * helmet))
        return drawing.shapes


@dataclass(frozen=True)
class Occluder(WallObject):
    """A plain grey board of a width and height [m] that hides what is behind it; placed by its lower left corner."""

    size: tuple[float, float]
    grey: float = 0.5

    def shapes(self) -> list[FlatShape]:
        """Return the painted shapes, bottom first."""
        drawing, (width, height) = self._drawing(), self.size
        drawing.rectangle((0.0, 0.0), self.size, Paint(self.grey, 0.08, 1.0, self.position))
        drawing.stroke([(0.0, 0.5 * height), (width, 0.5 * height)], 0.01, Paint(0.7 * self.grey))
        return drawing.shapes


class SceneObject(Protocol):
    """Something in a corridor; a frozen dataclass."""

    @property
    def name(self) -> str:
        """Unique in the corridor."""

    @property
    def surface(self) -> Surface:
        """The plane to which it belongs."""

    @property
    def position(self) -> tuple[float, float]:
        """Where it is on the plane, right and up [m]."""

    def shapes(self) -> list[FlatShape]:
        """Return the painted shapes, bottom first."""

    def landmarks(self) -> list[Landmark]:
        """Return what of it can be taught."""


@dataclass(frozen=True)
class CorridorScene:
    """The scene: objects, farthest first, and their light."""

    objects: tuple[SceneObject, ...]
    light: CorridorLight = field(default_factory=CorridorLight)

    @cached_property
    def table(self) -> ShapeTable:
        """All shapes, for the renderer."""
        return shape_table(shape for item in self.objects for shape in item.shapes())

    @cached_property
    def landmarks(self) -> tuple[Landmark, ...]:
        """What can be taught."""
        return tuple(landmark for item in self.objects for landmark in item.landmarks())

    def points_map(self) -> dict[str, NDArray[np.float64]]:
        """Return every point that can be taught by name, each of shape (3,), in the map frame [m]."""
        return {name: point for landmark in self.landmarks for name, point in landmark.points_map().items()}

    def item(self, name: str) -> SceneObject:
        """Return the thing of a name, or raise SceneError."""
        named = {item.name: item for item in reversed(self.objects)}
        if name not in named:
            there = ', '.join(item.name for item in self.objects)
            raise SceneError(f'there is no {name!r} in the corridor; it has {there}')
        return named[name]

    def move_object(self, name: str, right: float, up: float) -> CorridorScene:
        """Return the corridor with the thing of a name moved on its plane [m], or raise SceneError."""
        old = self.item(name)
        new = replace(cast(Any, old), position=(old.position[0] + right, old.position[1] + up))
        return replace(self, objects=tuple(new if item is old else item for item in self.objects))

    def with_objects(self, objects: Sequence[SceneObject]) -> CorridorScene:
        """Return the corridor with objects in front of all others, farthest first."""
        return replace(self, objects=(*self.objects, *objects))

    def cover_landmark(self, name: str) -> CorridorScene:
        """Return the corridor with a paper cover over the landmark of a name, or raise SceneError."""
        named = {landmark.name: landmark for landmark in reversed(self.landmarks)}
        if name not in named:
            raise SceneError(f'there is no landmark {name!r}; there are {", ".join(x.name for x in self.landmarks)}')
        (left, low), (right, high) = named[name].extent
        surface = named[name].surface.offset_plane(0.01)
        size = right - left + 0.06, high - low + 0.06
        return self.with_objects([Occluder(f'{name}_cover', surface, (left - 0.03, low - 0.03), size, 0.8)])
