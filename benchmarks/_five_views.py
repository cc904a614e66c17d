"""Repeat views of five identical meters in a row, and which of them can be decided, by the truth alone.

Half of the corridors have even gaps, half of them have nothing but the meters on the wall; in some of the views a
sheet of paper hides one meter. Needles differ in every view.
"""

import math
from collections.abc import Callable, Iterator
from dataclasses import replace
from itertools import count
from typing import NamedTuple

import numpy as np
from _stereo_scenes import RIG, Pair, random_offset, seen_by_both
from numpy.typing import NDArray

from scene_simulator.corridor.generator import METERS, CorridorDesign, corridor
from scene_simulator.corridor.scene import CorridorScene
from scene_simulator.corridor.stereo_rig import render_pair
from shirube_core.geometry import SE2

T_MAP_LESSON = SE2(-3.0, 0.0, 0.0)
FOCAL = RIG.left.intrinsics.fx
TAUGHT = 4
OFFSET, TURN = 0.5, math.radians(15.0)
DISTINGUISHABLE = 2.0
"""A meter farther from where one is expected is another one [px]: a hundred times what it is measured to."""
LANDMARKS_MIN = 3  # number of other landmarks in view that make the meters distinguishable
SEEN_MIN = 3  # fewer points are no landmark for shirube
BORDER = 30.0  # least distance from the image border of what is wholly in view [px]; meters have radii of 20 to 32
END_WALL = 0.3  # greatest depth of anything on the end wall [m]
DECIDABLE, UNDECIDABLE, OUT_OF_VIEW = 'decidable', 'not decidable', 'out of view'


class Lesson(NamedTuple):
    """A corridor as it is taught: its parameters, the numbers of the four meters of the target, and the images."""

    design: CorridorDesign
    chosen: tuple[int, ...]
    pair: Pair

    @property
    def scene(self) -> CorridorScene:
        """The corridor."""
        return corridor(self.design)

    @property
    def spacing(self) -> float:
        """Mean gap between neighbouring meters [m]."""
        return float(np.mean(np.diff(meter_row(self.scene))))


class MeterView(NamedTuple):
    """A view of a robot that comes back.

    The true pose in the taught frame, the number of the meter that is covered, None for none, whether the view is
    DECIDABLE, UNDECIDABLE or OUT_OF_VIEW, and the images.
    """

    T_lesson_base: SE2
    hidden: int | None
    status: str
    pair: Pair


def lessons(*, even: bool, bare: bool, seed: int, case: str = 'round', posters: bool = False) -> Iterator[Lesson]:
    """Yield corridors without end, taught from three metres: the paper's four left meters, but for round ones."""
    for number in count(seed):
        design = CorridorDesign(seed=number, even=even, bare=bare, case=case, posters=posters)
        pair = render_pair(corridor(design), RIG, T_MAP_LESSON, np.random.default_rng((number, 0)))
        first = number % (METERS - TAUGHT + 1) if case == 'round' else 0
        yield Lesson(design, tuple(range(first, first + TAUGHT)), pair)


def views(lesson: Lesson, wanted: int) -> Iterator[MeterView]:
    """Yield views of a lesson; every other one has a meter hidden."""
    design = lesson.design
    for number in range(wanted):
        rng = np.random.default_rng((design.seed, design.even, design.bare, 1 + number))
        offset = random_offset(OFFSET, TURN, rng)
        scene = corridor(replace(design, needles=1 + number))
        hidden = int(rng.integers(METERS)) if number % 2 else None
        shown = scene if hidden is None else scene.cover_landmark(f'meter_{hidden}')
        status = classify_view(scene, lesson.chosen, hidden, T_MAP_LESSON @ offset)
        yield MeterView(offset, hidden, status, render_pair(shown, RIG, T_MAP_LESSON @ offset, rng))


def meter_row(scene: CorridorScene) -> NDArray[np.float64]:
    """Return where the meters are along their wall, to the right, shape (METERS,) [m]."""
    return -meter_points(scene)[:, 1]


def meter_points(scene: CorridorScene) -> NDArray[np.float64]:
    """Return the middles of the meters in the map frame, shape (METERS, 3) [m]."""
    landmarks = {each.name: list(each.points_map().values()) for each in scene.landmarks}
    return np.array([np.mean(landmarks[f'meter_{i}'], axis=0) for i in range(METERS)])


def classify_view(scene: CorridorScene, chosen: tuple[int, ...], hidden: int | None, T_map_base: SE2) -> str:
    """Return whether a view can be decided.

    It is out of view when less than three meters of the target are seen by both cameras. Three or more landmarks beside
    the meters, wholly seen by both cameras when taught and now, decide it; else the spacing must.

    Args:
        scene: the corridor without the occluder of a meter.
        chosen: numbers of the meters of the target.
        hidden: number of the hidden one, None for none.
        T_map_base: where the robot is.
    """
    row, height = meter_row(scene), float(meter_points(scene)[0, 2])

    def in_view(along: NDArray[np.float64]) -> NDArray[np.bool_]:
        return seen_by_both(np.column_stack([0.0 * along, -along, 0.0 * along + height]), T_map_base, BORDER)

    shown = in_view(row) & (np.arange(METERS) != hidden)
    if shown[list(chosen)].sum() < SEEN_MIN:
        return OUT_OF_VIEW
    if landmarks_in_view(scene, T_map_base) >= LANDMARKS_MIN:
        return DECIDABLE
    tolerance = DISTINGUISHABLE * (-T_map_base.x - RIG.mount.xyz[0]) / FOCAL
    return DECIDABLE if is_spacing_unique(row, shown, in_view, tolerance) else UNDECIDABLE


def is_spacing_unique(
    row: NDArray[np.float64],
    shown: NDArray[np.bool_],
    in_view: Callable[[NDArray[np.float64]], NDArray[np.bool_]],
    tolerance: float,
) -> bool:
    """Return whether the taught row fits the visible meters in one place only.

    A place counts one for each taught meter that falls on a seen one, less one for each that falls where both cameras
    look and nothing is. The right place must count two more than any other where a taught meter falls on another one:
    that is the difference that one meter makes.

    Args:
        row: positions of the meters along the wall, shape (n,) [m].
        shown: which of them are seen, shape (n,).
        in_view: function that returns which places along the wall, shape (n,), both cameras see.
        tolerance: greatest distance of a meter from its expected position [m].
    """
    seen = row[shown]
    right = 2 * int(shown.sum()) - int(in_view(row).sum())
    shifts = (seen - row[:, None]).ravel()
    for shift in shifts[np.abs(shifts) > 2.0 * tolerance]:
        # That which fits most is at an end of the range of shifts that some meter tolerates.
        for place in (row + shift + end for end in (-tolerance, 0.0, tolerance)):
            fits = (np.abs(place[:, None] - seen) <= 1.001 * tolerance).any(axis=1)
            if fits.sum() - (in_view(place) & ~fits).sum() > right - 2:
                return False
    return True


def landmarks_in_view(scene: CorridorScene, T_map_base: SE2) -> int:
    """Return how many landmarks of the end wall but the meters both cameras see wholly, when taught and now."""
    total = 0
    for landmark in scene.landmarks:
        points = np.array(list(landmark.points_map().values()))
        on_wall = bool(np.all(points[:, 0] > -END_WALL))
        if on_wall and not landmark.name.startswith(('meter', 'repeated')):
            total += all(bool(seen_by_both(points, pose, BORDER).all()) for pose in (T_MAP_LESSON, T_map_base))
    return total
