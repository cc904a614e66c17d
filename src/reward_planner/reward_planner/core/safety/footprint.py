"""The robot's footprint: a convex or concave polygon, or a circle, with its distance to points."""

import math
from collections.abc import Sequence

import cv2
import numpy as np
from numba import njit
from numpy.typing import NDArray

from reward_planner.core.reward_planner_error import RewardPlannerError

_CIRCLE_CORNERS = 24


class Footprint:
    """Outline of the robot on the floor.

    Attributes:
        corners: shape (n, 2), in the base frame [m], counter-clockwise.
        radius: largest distance of a corner from the base frame's origin [m].
    """

    def __init__(self, corners: Sequence[float], circle_radius: float) -> None:
        """Take x, y of each corner [m]; without corners a circle.

        Raises:
            RewardPlannerError: an odd number of coordinates, fewer than three corners, no area, or crossing edges.
        """
        if not corners:
            angles = np.arange(_CIRCLE_CORNERS) * (math.tau / _CIRCLE_CORNERS)
            outer = circle_radius / math.cos(math.pi / _CIRCLE_CORNERS)  # the polygon holds the circle
            self.corners = outer * np.column_stack([np.cos(angles), np.sin(angles)])
        else:
            if len(corners) % 2 or len(corners) < 6:
                raise RewardPlannerError(f'footprint has {len(corners)} numbers; give x and y of three or more corners')
            self.corners = np.array(corners, dtype=np.float64).reshape(-1, 2)
            x, y = self.corners.T
            area = 0.5 * float(x @ np.roll(y, -1) - y @ np.roll(x, -1))
            if abs(area) < 1e-4 or _has_crossing(self.corners):
                raise RewardPlannerError('footprint has no area or its edges cross; give its corners in order')
            if area < 0.0:
                self.corners = self.corners[::-1].copy()
        self.radius = float(np.hypot(*self.corners.T).max())

    @property
    def inscribed_radius(self) -> float:
        """Radius of the greatest circle around the base frame's origin in the footprint [m].

        Raises:
            RewardPlannerError: the origin is outside of the footprint.
        """
        radius = -float(polygon_distance(self.corners, 0.0, 0.0))
        if radius <= 0.0:
            raise RewardPlannerError('footprint does not contain the origin of base_frame; give corners around it')
        return radius

    def distances(self, points_base: NDArray[np.float64]) -> NDArray[np.float64]:
        """Return the distances of points, shape (n, 2), from the outline [m], shape (n,), negative inside."""
        return np.array([polygon_distance(self.corners, x, y) for x, y in points_base.tolist()])

    def inflated(self, margin: float) -> NDArray[np.float64]:
        """Return the convex hull widened by a margin [m], shape (n, 2), to be shown."""
        angles = np.arange(_CIRCLE_CORNERS) * (math.tau / _CIRCLE_CORNERS)
        rim = margin * np.column_stack([np.cos(angles), np.sin(angles)])
        return convex_hull((self.corners[:, None] + rim).reshape(-1, 2))


def convex_hull(points: NDArray[np.float64]) -> NDArray[np.float64]:
    """Return the convex hull of points, shape (n, 2), counter-clockwise, shape (m, 2)."""
    hull = cv2.convexHull(np.ascontiguousarray(points, dtype=np.float32))
    return np.asarray(hull, dtype=np.float64).reshape(-1, 2)


def _has_crossing(corners: NDArray[np.float64]) -> bool:
    ends = np.roll(corners, -1, axis=0)
    count = len(corners)
    for i in range(count):
        for j in range(i + 2, count - (i == 0)):
            if (
                _sides(corners[i], ends[i], corners[j], ends[j])
                < 0.0
                > _sides(corners[j], ends[j], corners[i], ends[i])
            ):
                return True
    return False


def _sides(a: NDArray[np.float64], b: NDArray[np.float64], p: NDArray[np.float64], q: NDArray[np.float64]) -> float:
    """Return a negative number if p and q are on different sides of the line through a and b."""
    line = b - a
    left, right = (line[0] * (point - a)[1] - line[1] * (point - a)[0] for point in (p, q))
    return float(left * right)


@njit(cache=True)
def polygon_distance(corners: NDArray[np.float64], x: float, y: float) -> float:
    """Return the distance of a point from a polygon, shape (n, 2), negative inside [m]."""
    nearest, inside, last = math.inf, False, len(corners) - 1
    for k in range(len(corners)):
        ax, ay, bx, by = corners[last, 0], corners[last, 1], corners[k, 0], corners[k, 1]
        dx, dy = bx - ax, by - ay
        t = ((x - ax) * dx + (y - ay) * dy) / max(dx * dx + dy * dy, 1e-18)
        t = min(max(t, 0.0), 1.0)
        nearest = min(nearest, math.hypot(ax + t * dx - x, ay + t * dy - y))
        if (ay > y) != (by > y) and x < ax + (y - ay) / (by - ay) * dx:
            inside = not inside
        last = k
    return -nearest if inside else nearest
