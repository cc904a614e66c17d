"""A room of boxes and its depth images: racks, table tops and overhangs are all boxes."""

from __future__ import annotations

import math
from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np
from numba import njit
from numpy.typing import ArrayLike, NDArray

from scene_simulator.errors import SceneError
from shirube_core.geometry import PinholeCamera

Box = tuple[float, float, float, float, float, float]  # x, y and z of the lowest and then of the highest corner [m]


@dataclass(frozen=True)
class BoxRoom:
    """A room, seen from inside, and solid boxes in it.

    Attributes:
        size: the room's own corners; its floor, ceiling and walls are seen.
        boxes: boxes in the room.

    Raises:
        SceneError: a box without volume.
    """

    size: Box
    boxes: tuple[Box, ...] = ()

    def __post_init__(self) -> None:
        for box in (self.size, *self.boxes):
            if not all(low < high for low, high in zip(box[:3], box[3:], strict=True)):
                raise SceneError(f'box {box} has no volume; give the lowest corner, then the highest')

    def depth_image(
        self, camera: PinholeCamera, T_map_camera: NDArray[np.float64], solids: Solids | None = None
    ) -> NDArray[np.float32]:
        """Return the depth along the optical axis, shape (height, width) [m], seen from T_map_camera, shape (4, 4)."""
        v, u = np.mgrid[: camera.height, : camera.width]
        rays = camera.rays_from_pixels(np.column_stack([u.ravel(), v.ravel()])) @ T_map_camera[:3, :3].T  # of depth 1
        depth = cast_rays(self, solids or Solids(), T_map_camera[:3, 3], rays)
        return depth.reshape(u.shape).astype(np.float32)

    def solid_cells(
        self, corner: tuple[float, float], resolution: float, shape: tuple[int, int], heights: tuple[float, float]
    ) -> NDArray[np.bool_]:
        """Return which cells of a grid touch something solid at some heights, shape (rows, columns).

        Args:
            corner: x and y of the lower left corner of cell (0, 0) [m].
            resolution: side of a cell [m].
            shape: rows along y and columns along x.
            heights: lowest and highest [m].
        """
        low_x = corner[0] + resolution * np.arange(shape[1])
        low_y = corner[1] + resolution * np.arange(shape[0])
        x0, y0, _, x1, y1, _ = self.size
        inside_x, inside_y = ((low_x > x0) & (low_x + resolution < x1), (low_y > y0) & (low_y + resolution < y1))
        solid = ~(inside_y[:, None] & inside_x[None])
        for x0, y0, z0, x1, y1, z1 in self.boxes:
            if z0 < heights[1] and z1 > heights[0]:
                in_x, in_y = ((low_x < x1) & (low_x + resolution > x0), (low_y < y1) & (low_y + resolution > y0))
                solid |= in_y[:, None] & in_x[None]
        return solid


def add_disparity_noise(
    depth: NDArray[np.float32], focal_baseline: float, sigma: float, rng: np.random.Generator
) -> NDArray[np.float32]:
    """Return depths [m] as a stereo camera measures them, with normal noise of the disparity f b / Z.

    The product f b is ``focal_baseline`` [px m], the standard deviation of the disparity is sigma [px].
    """
    disparity = focal_baseline / depth + rng.normal(0.0, sigma, depth.shape)
    return (focal_baseline / np.maximum(disparity, 1e-3)).astype(np.float32)


def points_from_depth(depth: NDArray[np.float32], camera: PinholeCamera) -> NDArray[np.float32]:
    """Return the points of a depth image, shape (height * width, 3), in the optical frame [m]."""
    u = (np.arange(camera.width, dtype=np.float32) - np.float32(camera.cx)) / np.float32(camera.fx)
    v = (np.arange(camera.height, dtype=np.float32) - np.float32(camera.cy)) / np.float32(camera.fy)
    return np.stack([u[None] * depth, v[:, None] * depth, depth], axis=2).reshape(-1, 3)


def forward_camera(x: float, y: float, height: float, yaw: float) -> NDArray[np.float64]:
    """Return T_map_camera, shape (4, 4), of a level camera at a place [m] whose optical axis has a yaw [rad]."""
    cos, sin = math.cos(yaw), math.sin(yaw)
    return np.array([[sin, 0.0, cos, x], [-cos, 0.0, sin, y], [0.0, -1.0, 0.0, height], [0.0, 0.0, 0.0, 1.0]])


@njit(cache=True)
def intersect_box(
    box: NDArray[np.float64], start: NDArray[np.float64], ray: NDArray[np.float64]
) -> tuple[float, float]:
    """Return where a ray enters and leaves a box, in lengths of the ray."""
    t_entry, t_exit = -math.inf, math.inf
    for k in range(3):
        if ray[k] == 0.0:
            if not box[k] < start[k] < box[k + 3]:
                return math.inf, -math.inf
            continue
        first, second = (box[k] - start[k]) / ray[k], (box[k + 3] - start[k]) / ray[k]
        t_entry, t_exit = max(t_entry, min(first, second)), min(t_exit, max(first, second))
    return t_entry, t_exit


def disc_clearance(room: BoxRoom, x: float, y: float, radius: float, height: float) -> float:
    """Return the clearance between an upright cylinder at (x, y) and the nearest box or wall [m]; 0 or less in contact.

    Boxes that begin above the height of the cylinder do not count.
    """
    x0, y0, floor, x1, y1, _ = room.size
    nearest = min(x - x0, x1 - x, y - y0, y1 - y)
    for left, low, bottom, right, high, _ in room.boxes:
        if bottom < floor + height:
            distance = math.hypot(max(left - x, 0.0, x - right), max(low - y, 0.0, y - high))
            nearest = min(nearest, distance)
    return nearest - radius


Cylinder = tuple[float, float, float, float, float, float, float]  # x, y and z of both ends of the axis, radius [m]
TurnedBox = tuple[float, float, float, float, float, float, float]
"""x and y of the middle [m], yaw [rad], half length and half width, lowest and highest z [m]."""


@dataclass(frozen=True)
class Solids:
    """Bodies at one time: upright or lying cylinders, and boxes that are turned about the vertical."""

    cylinders: tuple[Cylinder, ...] = ()
    boxes: tuple[TurnedBox, ...] = ()

    def __add__(self, other: Solids) -> Solids:
        """Return both."""
        return Solids(self.cylinders + other.cylinders, self.boxes + other.boxes)

    def clearance(self, x: float, y: float, radius: float, height: float) -> float:
        """Return the gap to an upright cylinder on the floor at (x, y) [m], negative where they overlap."""
        nearest = math.inf
        for cx, cy, yaw, length, width, low in self._outlines():
            cos, sin = math.cos(yaw), math.sin(yaw)
            a, b = abs(cos * (x - cx) + sin * (y - cy)), abs(cos * (y - cy) - sin * (x - cx))
            if low < height:
                nearest = min(nearest, math.hypot(max(a - length, 0.0), max(b - width, 0.0)))
        for ax, ay, az, bx, by, bz, r in self.cylinders:
            if (ax, ay) == (bx, by) and min(az, bz) < height:
                nearest = min(nearest, math.hypot(ax - x, ay - y) - r)
        return nearest - radius

    def _outlines(self) -> Iterator[tuple[float, float, float, float, float, float]]:
        """Yield middle, yaw, half length, half width and lowest z of each box and lying cylinder."""
        for cx, cy, yaw, length, width, low, _ in self.boxes:
            yield cx, cy, yaw, length, width, low
        for ax, ay, az, bx, by, _, r in self.cylinders:
            if (ax, ay) != (bx, by):
                half = 0.5 * math.hypot(bx - ax, by - ay)
                yield 0.5 * (ax + bx), 0.5 * (ay + by), math.atan2(by - ay, bx - ax), half, r, az - r


def cast_rays(room: BoxRoom, solids: Solids, origin: ArrayLike, directions: NDArray[np.float64]) -> NDArray[np.float64]:
    """Return where rays meet the nearest surface, in lengths of each direction, shape (n,).

    Args:
        room: room of boxes.
        solids: bodies in it.
        origin: start of the rays, shape (3,) [m].
        directions: shape (n, 3).
    """
    return _cast(
        np.asarray(origin, dtype=np.float64),
        np.ascontiguousarray(directions),
        np.array(room.size),
        np.array(room.boxes, dtype=np.float64).reshape(-1, 6),
        np.array(solids.cylinders, dtype=np.float64).reshape(-1, 7),
        np.array(solids.boxes, dtype=np.float64).reshape(-1, 7),
    )


@njit(cache=True)
def _cast(
    origin: NDArray[np.float64],
    directions: NDArray[np.float64],
    size: NDArray[np.float64],
    boxes: NDArray[np.float64],
    cylinders: NDArray[np.float64],
    turned: NDArray[np.float64],
) -> NDArray[np.float64]:
    found = np.empty(len(directions))
    local_origin, local, box = np.empty(3), np.empty(3), np.empty(6)
    for n in range(len(directions)):
        ray = directions[n]
        nearest = intersect_box(size, origin, ray)[1]
        for k in range(len(boxes)):
            t_entry, t_exit = intersect_box(boxes[k], origin, ray)
            if 0.0 < t_entry < t_exit and t_entry < nearest:
                nearest = t_entry
        for k in range(len(cylinders)):
            t_entry = _intersect_cylinder(cylinders[k], origin, ray)
            if 0.0 < t_entry < nearest:
                nearest = t_entry
        for k in range(len(turned)):
            cos, sin = math.cos(turned[k, 2]), math.sin(turned[k, 2])
            dx, dy = origin[0] - turned[k, 0], origin[1] - turned[k, 1]
            local_origin[0], local_origin[1], local_origin[2] = (cos * dx + sin * dy, cos * dy - sin * dx, origin[2])
            local[0], local[1], local[2] = cos * ray[0] + sin * ray[1], cos * ray[1] - sin * ray[0], ray[2]
            box[0], box[1], box[2] = -turned[k, 3], -turned[k, 4], turned[k, 5]
            box[3], box[4], box[5] = turned[k, 3], turned[k, 4], turned[k, 6]
            t_entry, t_exit = intersect_box(box, local_origin, local)
            if 0.0 < t_entry < t_exit and t_entry < nearest:
                nearest = t_entry
        found[n] = nearest
    return found


@njit(cache=True)
def _intersect_cylinder(cylinder: NDArray[np.float64], origin: NDArray[np.float64], ray: NDArray[np.float64]) -> float:
    """Return where a ray enters a cylinder with flat ends, in lengths of the ray; infinity if it does not."""
    ax, ay, az = cylinder[3] - cylinder[0], cylinder[4] - cylinder[1], cylinder[5] - cylinder[2]
    length = math.sqrt(ax * ax + ay * ay + az * az)
    ax, ay, az = ax / length, ay / length, az / length
    ox, oy, oz = origin[0] - cylinder[0], origin[1] - cylinder[1], origin[2] - cylinder[2]
    along_ray, along_origin = ray[0] * ax + ray[1] * ay + ray[2] * az, ox * ax + oy * ay + oz * az
    px, py, pz = ray[0] - along_ray * ax, ray[1] - along_ray * ay, ray[2] - along_ray * az
    qx, qy, qz = ox - along_origin * ax, oy - along_origin * ay, oz - along_origin * az
    a, b = px * px + py * py + pz * pz, px * qx + py * qy + pz * qz
    c = qx * qx + qy * qy + qz * qz - cylinder[6] ** 2
    low, high = -math.inf, math.inf
    if a > 1e-12:
        root = b * b - a * c
        if root < 0.0:
            return math.inf
        low, high = (-b - math.sqrt(root)) / a, (-b + math.sqrt(root)) / a
    elif c > 0.0:
        return math.inf
    if abs(along_ray) > 1e-12:
        one, two = -along_origin / along_ray, (length - along_origin) / along_ray
        low, high = max(low, min(one, two)), min(high, max(one, two))
    elif not 0.0 < along_origin < length:
        return math.inf
    return low if low < high else math.inf
