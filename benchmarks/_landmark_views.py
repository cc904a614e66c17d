"""A panel on a wall, or a printed tag of its size in its place, seen by a robot that comes back."""

import math
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from itertools import groupby
from typing import NamedTuple

import numpy as np
from _stereo_scenes import RIG, Pair, random_offset, seen_by_both
from numpy.typing import NDArray

from scene_simulator.corridor.drawing import Drawing
from scene_simulator.corridor.generator import CorridorDesign, corridor
from scene_simulator.corridor.instruments import Cabinet
from scene_simulator.corridor.scene import CorridorScene, SceneObject
from scene_simulator.corridor.shapes import FlatShape, Landmark, Paint, SquareLandmark, Surface, facing_wall
from scene_simulator.corridor.stereo_rig import render_pair
from shirube_core.geometry import SE2

SIDE = 0.8  # of the tag's black square; the fields of the panel span as much from left to right [m]
HEIGHT = RIG.mount.xyz[2]
DEPTH = 0.1
SURFACE = facing_wall(0.0)
FIELDS = 6
OFFSET, TURN = 0.5, math.radians(15.0)
TEACH_OFFSET, TEACH_TURN = 0.05, math.radians(2.0)
BORDER = 12.0  # panel and tag are so far inside of both images [px]
WHITE, BLACK = Paint(0.9), Paint(0.08)


@dataclass(frozen=True)
class PrintedTag:
    """A printed tag, its middle on a plane [m], and its cells, true for white, the black border included."""

    name: str
    surface: Surface
    position: tuple[float, float]
    cells: tuple[tuple[bool, ...], ...]

    def shapes(self) -> list[FlatShape]:
        """Return white paper, the black square, and the white runs of its rows and columns.

        Runs along both directions overlap, so that no seam shows between neighbouring white cells.
        """
        drawing, half, cell = Drawing(self.surface, self.position), 0.5 * SIDE, SIDE / len(self.cells)
        drawing.rectangle((-half - cell, -half - cell), (half + cell, half + cell), WHITE)
        drawing.rectangle((-half, -half), (half, half), BLACK)
        for row, line in enumerate(self.cells):
            top = half - row * cell
            for start, stop in white_runs(line):
                drawing.rectangle((start * cell - half, top - cell), (stop * cell - half, top), WHITE)
        for column, line in enumerate(zip(*self.cells, strict=True)):
            left = column * cell - half
            for start, stop in white_runs(line):
                drawing.rectangle((left, half - stop * cell), (left + cell, half - start * cell), WHITE)
        return drawing.shapes

    def landmarks(self) -> list[Landmark]:
        """Return the black square."""
        (x, y), half = self.position, 0.5 * SIDE
        return [SquareLandmark(self.name, self.surface, (x - half, y - half), (x + half, y + half))]


class LandmarkView(NamedTuple):
    """The true pose, and from there the panel and, in another pair of pictures, the tag."""

    T_map_base: SE2
    panel: Pair
    tag: Pair


class LandmarkWall:
    """The end wall of a corridor, by its seed, with nothing but the panel, or the tag of these cells."""

    def __init__(self, seed: int, cells: NDArray[np.bool_]) -> None:
        bare = corridor(CorridorDesign(seed=seed, bare=True))
        walls: Sequence[SceneObject] = [item for item in bare.objects if not item.name.startswith('meter')]
        rows = tuple(map(tuple, cells.tolist()))
        tag = PrintedTag('tag', SURFACE.offset_plane(DEPTH), (0.0, HEIGHT), rows)
        panel = Cabinet('panel', SURFACE, (-0.46, HEIGHT - 0.4), (0.92, 0.8), DEPTH, columns=3)
        self.with_panel = CorridorScene((*walls, panel))
        self.with_tag = CorridorScene((*walls, tag))

    def view(self, T_map_base: SE2, rng: np.random.Generator) -> LandmarkView:
        """Return both pairs of pictures."""
        pairs = [render_pair(scene, RIG, T_map_base, rng) for scene in (self.with_panel, self.with_tag)]
        return LandmarkView(T_map_base, *pairs)

    def field_corners(self) -> NDArray[np.float64]:
        """Return the corners of the fields, shape (FIELDS, 4, 3), clockwise from the upper left, in the map [m]."""
        points = self.with_panel.points_map()
        return np.array([[points[f'panel/field_{i}/{k}'] for k in range(4)] for i in range(FIELDS)])


def white_runs(line: Sequence[bool]) -> list[tuple[int, int]]:
    """Return where runs of white cells begin and end."""
    runs = [(white, len(list(cells))) for white, cells in groupby(line)]
    ends = np.cumsum([0, *(length for _, length in runs)]).tolist()
    return [(ends[i], ends[i + 1]) for i, (white, _) in enumerate(runs) if white]


def teach_pose(distance: float, rng: np.random.Generator) -> SE2:
    """Return a pose from which the left camera is about so far from the panel [m]."""
    offset = random_offset(TEACH_OFFSET, TEACH_TURN, rng)
    return SE2(offset.x - distance - DEPTH - RIG.mount.xyz[0], offset.y, offset.yaw)


def repeat_poses(T_map_lesson: SE2, rng: np.random.Generator) -> Iterator[SE2]:
    """Yield poses without end, within half a metre and 15 degrees of a lesson, that see all of panel and tag."""
    half = 0.5 * SIDE * 1.25
    corners = np.array([(-DEPTH, y, HEIGHT + z) for y in (-half, half) for z in (-half, half)])
    while True:
        pose = T_map_lesson @ random_offset(OFFSET, TURN, rng)
        if seen_by_both(corners, pose, BORDER).all():
            yield pose
