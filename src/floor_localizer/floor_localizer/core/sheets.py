"""Sheets of one map: floors of a building, laid side by side so that one index tells them apart."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass

from floor_localizer.core.floor_localizer_error import FloorLocalizerError
from shirube_geometry import PlanarPose

# Farther apart than any constellation reaches [m].
_GAP = 2.0
# Single precision keeps a dot to 0.03 mm there [m].
_WIDEST = 1024.0


@dataclass(frozen=True)
class Sheet:
    """One floor within the map.

    Attributes:
        name: of the floor.
        offset: x and y of the floor's own origin in the map [m].
        lower: the lower left corner of its dots in the map [m].
        upper: the upper right corner [m].
    """

    name: str
    offset: tuple[float, float]
    lower: tuple[float, float]
    upper: tuple[float, float]

    def pose_on_map(self, T_sheet_base: PlanarPose) -> PlanarPose:
        """Return where a pose on the floor lies in the map."""
        return PlanarPose(T_sheet_base.x + self.offset[0], T_sheet_base.y + self.offset[1], T_sheet_base.yaw)

    def pose_on_sheet(self, T_map_base: PlanarPose) -> PlanarPose:
        """Return a pose of the map in the frame of the floor; the inverse of `pose_on_map`."""
        return PlanarPose(T_map_base.x - self.offset[0], T_map_base.y - self.offset[1], T_map_base.yaw)


def lay_out_sheets(
    names: Sequence[str], corners: Sequence[tuple[float, float, float, float]]
) -> tuple[Sheet, ...]:
    """Lay floors side by side in rows that make about a square.

    Args:
        names: of the floors.
        corners: for each x and y of the lower left and of the upper right corner of its dots, in its own frame [m].

    Raises:
        FloorLocalizerError: the floors together are wider than single precision allows.
    """
    columns = math.ceil(math.sqrt(len(names)))
    width = math.ceil(max(x1 - x0 for x0, _, x1, _ in corners) + _GAP)
    height = math.ceil(max(y1 - y0 for _, y0, _, y1 in corners) + _GAP)
    if len(names) > 1 and max(width * columns, height * math.ceil(len(names) / columns)) > _WIDEST:
        raise FloorLocalizerError(
            f'{len(names)} sheets of up to {width} x {height} m are too large for one map of {_WIDEST:.0f} m; '
            'make several maps'
        )
    sheets = []
    for number, (name, (x0, y0, x1, y1)) in enumerate(zip(names, corners, strict=True)):
        row, column = divmod(number, columns)
        # Whole metres, so that single precision changes the floor as little as possible.
        dx, dy = float(column * width - math.floor(x0)), float(row * height - math.floor(y0))
        sheets.append(Sheet(name, (dx, dy), (x0 + dx, y0 + dy), (x1 + dx, y1 + dy)))
    return tuple(sheets)


def sheet_of(sheets: Sequence[Sheet], x: float, y: float) -> Sheet | None:
    """Return the floor that a place of the map [m] is on: the nearest one, None for a map without sheets."""
    return min(sheets, key=lambda sheet: _distance(sheet, x, y), default=None)


def _distance(sheet: Sheet, x: float, y: float) -> float:
    dx = max(sheet.lower[0] - x, 0.0, x - sheet.upper[0])
    dy = max(sheet.lower[1] - y, 0.0, y - sheet.upper[1])
    return math.hypot(dx, dy)
