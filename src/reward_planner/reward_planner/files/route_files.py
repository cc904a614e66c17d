"""Files of a route: its points and the rewards of its steps as CSV, and its picture."""

from collections.abc import Iterable
from pathlib import Path

import cv2
import numpy as np
from numpy.typing import NDArray

from reward_planner.core.occupancy_map import FREE_THRESHOLD, GridFrame, OccupancyMap
from reward_planner.core.reward.reward_walk import ExplainedCell
from reward_planner.core.reward.step_reward import TERM_NAMES
from shirube_core.files import atomic_write, write_text

_LONG_SIDE_MIN = 800  # least size of the long side of the picture [px]
_FREE, _UNKNOWN, _OCCUPIED, _INFLATED = (255, 255, 255), (205, 205, 205), (0, 0, 0), (200, 215, 250)
_ROUTE, _START, _GOAL = (200, 60, 0), (0, 150, 0), (0, 0, 220)  # BGR
_HEAD = ('number', 'x', 'y', 'to_x', 'to_y', *TERM_NAMES, 'total', 'can_enter', 'taken')


def save_route_table(path: Path, points_map: NDArray[np.float64]) -> None:
    """Write the points of a route in the map frame [m], shape (n, 2), atomically: one line ``x,y`` per cell."""
    lines = [f'{x:.4f},{y:.4f}\n' for x, y in points_map.tolist()]
    write_text(path, ''.join(['x,y\n', *lines]))


def save_reward_table(path: Path, cells: Iterable[ExplainedCell], frame: GridFrame) -> None:
    """Write the rewards along a path atomically: eight lines per cell, one for each step; positions are in metres."""
    lines = [','.join(_HEAD)]
    for number, at in enumerate(cells):
        x, y = frame.centre_of(at.cell)
        for reward in at.rewards:
            rows, columns = reward.step
            to_x, to_y = x + columns * frame.resolution, y + rows * frame.resolution
            terms = (f'{reward.terms.get(name, 0.0):.3f}' for name in TERM_NAMES)
            flags = (int(reward.can_enter), int(reward.step == at.taken))
            places = (f'{place:.4f}' for place in (x, y, to_x, to_y))
            lines.append(','.join(map(str, (number, *places, *terms, f'{reward.total:.3f}', *flags))))
    write_text(path, '\n'.join([*lines, '']))


def draw_route(grid: OccupancyMap, blocked: NDArray[np.bool_], cells: NDArray[np.int64]) -> NDArray[np.uint8]:
    """Return a BGR picture, shape (h, w, 3), one or more pixels per cell; its first line is the map's highest row.

    Inflated obstacles, shape (rows, columns), are tinted; the route is rows and columns, shape (n, 2), n may be 0.
    """
    picture = np.full((*grid.frame.shape, 3), _UNKNOWN, dtype=np.uint8)
    picture[(grid.occupancy >= 0) & (grid.occupancy < FREE_THRESHOLD)] = _FREE
    picture[blocked] = _INFLATED
    picture[grid.occupied()] = _OCCUPIED
    scale = max(1, -(-_LONG_SIDE_MIN // max(grid.frame.shape)))
    large = np.ascontiguousarray(picture[::-1].repeat(scale, axis=0).repeat(scale, axis=1))
    pixels = (scale * (np.stack([cells[:, 1], grid.frame.rows - 1 - cells[:, 0]], axis=1) + 0.5)).astype(np.int32)
    thickness = max(2, scale // 3)
    cv2.polylines(large, [pixels.reshape(-1, 1, 2)], isClosed=False, color=_ROUTE, thickness=thickness)
    for ends, colour in ((pixels[:1], _START), (pixels[-1:], _GOAL)):
        for x, y in ends.tolist():
            cv2.circle(large, (x, y), max(3, scale), colour, -1)
    return large


def save_picture(path: Path, pixels: NDArray[np.uint8]) -> None:
    """Write a PNG atomically."""
    data = cv2.imencode('.png', pixels)[1]
    with atomic_write(path) as file:
        file.write(data.tobytes())
