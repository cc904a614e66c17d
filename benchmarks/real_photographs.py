"""Real photographs located without a prior: printed random-dot sheets and terrazzo, whose truth is known.

Each sheet in ``image00.jpg`` and in the movie is made a view from straight above, in a random heading, and located in
the map of all 120 sheets side by side. Views of terrazzo are cut from one picture at known places, with errors of
scale, brightness, light and noise, and located in the map that the detector makes of the whole picture (terrazzo018 of
ambientCG, CC0).
"""

import math
from collections.abc import Iterator
from functools import cache
from typing import NamedTuple

import cv2
import numpy as np
from _figures import Figure, error, outcomes, rate, rms
from _harness import Option, Run, progress, run_benchmark
from _photographed_sheets import (
    MEASURED_EVERY,
    PHOTOGRAPH,
    SHEETS,
    VIEW_CAMERA,
    VIEW_MOUNT,
    SheetView,
    load_sheets,
    random_view_pose,
    sheet_map,
    sheet_origin,
    sheet_views,
)
from numpy.typing import NDArray

from floor_localizer.core.constellation.indexed_map import index_map
from floor_localizer.core.dot_extraction.detector import DotDetector
from floor_localizer.core.dots import DotMap
from floor_localizer.core.fix import Fix
from floor_localizer.core.localizer import FloorLocalizer
from floor_localizer.core.settings import DotDetectorSettings
from scene_simulator.floor.camera import PAPER_CAMERA
from shirube_core.geometry import SE2

AGREEMENT = 0.0005  # of a right pose with the truth, at the sheet's centre [m]
TERRAZZO = ('floor_terrazzo', 'terrazzo018.jpg')
SCALE = VIEW_MOUNT.xyz[2] / PAPER_CAMERA.fx
"""Of the picture: 0.383 mm/px, so that 1024 px are 392 mm and a view of the default camera is 90 mm wide [m/px]."""
SCALE_ERROR = 0.02  # greatest, of a view
NOISE = 4.0  # standard deviation of a view's grey levels
GAIN = (0.6, 1.15)  # of a view's brightness
GRADIENT = 0.15  # greatest change of brightness from the middle of a view to its side


class Trial(NamedTuple):
    """A view, located: 'right', 'none' or 'wrong', errors of position [m] and heading [rad], match rate.

    ``without_it`` is the outcome with the sheet left out of the map.
    """

    outcome: str
    error: float = math.nan
    turn: float = math.nan
    match_rate: float = math.nan
    without_it: str = ''


class SheetBench:
    """The map of all sheets, ready to locate views in it."""

    def __init__(self, sheets: list[NDArray[np.float64]]) -> None:
        self._without = cache(lambda sheet: FloorLocalizer(index_map(sheet_map(sheets, sheet)), VIEW_MOUNT))

    def trial(self, view: SheetView, generator: np.random.Generator) -> Trial:
        """Locate one sheet."""
        pose = random_view_pose(generator)
        dots = self._without(None).detect(view.from_above(pose))
        fix = self._without(None).locate_dots(dots, VIEW_CAMERA)
        without = self._without(view.sheet).locate_dots(dots, VIEW_CAMERA)
        without_it = 'wrong' if isinstance(without, Fix) else 'none'
        if not isinstance(fix, Fix):
            return Trial('none', without_it=without_it)
        middle = pose.inverse().transform(np.zeros((1, 2)))
        distance = float(np.linalg.norm(fix.T_map_base.transform(middle)[0] - sheet_origin(view.sheet)))
        outcome = 'right' if distance <= AGREEMENT else 'wrong'
        return Trial(outcome, distance, abs(pose.yaw_to(fix.T_map_base)), fix.match_rate, without_it)


def terrazzo_map(picture: NDArray[np.uint8], detector: DotDetector) -> DotMap:
    """Return the dots that a detector finds on the whole picture; x to the right, y up, from the lower left [m]."""
    dots = detector.detect(picture)
    return DotMap(_map_points(dots.pixels, picture), dots.diameters * SCALE)


def cut_view(picture: NDArray[np.uint8], generator: np.random.Generator) -> tuple[NDArray[np.uint8], SE2]:
    """Cut a view, and return the pose: a random place and heading, with errors of scale, brightness and noise."""
    height, width = picture.shape[:2]
    reach = math.hypot(PAPER_CAMERA.width, PAPER_CAMERA.height) / 2.0 * (1.0 + SCALE_ERROR) + 1.0
    middle = generator.uniform(reach, np.array([width, height]) - reach)
    yaw = generator.uniform(-math.pi, math.pi)
    x, y = _map_points(middle[None], picture)[0]
    pose = SE2(float(x), float(y), yaw)
    scale = 1.0 + generator.uniform(-SCALE_ERROR, SCALE_ERROR)
    columns, rows = np.meshgrid(np.arange(PAPER_CAMERA.width), np.arange(PAPER_CAMERA.height))
    rays = PAPER_CAMERA.rays_from_pixels(np.column_stack([columns.ravel(), rows.ravel()]))
    points = pose.transform(scale * VIEW_MOUNT.floor_points_from_rays(rays))
    pixels = np.column_stack([points[:, 0] / SCALE - 0.5, height - 0.5 - points[:, 1] / SCALE])
    u, v = np.moveaxis(pixels.astype(np.float32).reshape(PAPER_CAMERA.height, PAPER_CAMERA.width, 2), 2, 0)
    cut = cv2.remap(picture, u, v, cv2.INTER_CUBIC).astype(np.float64)
    sides = np.stack([columns - PAPER_CAMERA.cx, rows - PAPER_CAMERA.cy], axis=-1) / PAPER_CAMERA.cx
    light = generator.uniform(*GAIN) * (1.0 + sides @ generator.uniform(-GRADIENT, GRADIENT, 2))
    noisy = cut * light[..., None] + generator.normal(0.0, NOISE, cut.shape)
    return np.clip(np.round(noisy), 0, 255).astype(np.uint8), pose


def _map_points(pixels: NDArray[np.float64], picture: NDArray[np.uint8]) -> NDArray[np.float64]:
    return np.column_stack([pixels[:, 0] + 0.5, picture.shape[0] - 0.5 - pixels[:, 1]]) * SCALE


def terrazzo_trials(picture: NDArray[np.uint8], detector: DotDetector, views: int, seed: int) -> Iterator[Trial]:
    """Yield random views of the terrazzo, located."""
    localizer = FloorLocalizer(index_map(terrazzo_map(picture, detector)), VIEW_MOUNT, None, detector)
    generator = np.random.default_rng(seed)
    for _ in range(views):
        image, pose = cut_view(picture, generator)
        fix = localizer.locate(image, PAPER_CAMERA)
        if not isinstance(fix, Fix):
            yield Trial('none')
            continue
        distance, turn = fix.T_map_base.distance_to(pose), abs(pose.yaw_to(fix.T_map_base))
        yield Trial('right' if distance <= AGREEMENT else 'wrong', distance, turn, fix.match_rate)


def add_sheets(run: Run, every: int) -> None:
    """Add what became of the sheets."""
    bench, generator = SheetBench(load_sheets(run.data(SHEETS))), np.random.default_rng(run.seed)
    groups: dict[str, list[Trial]] = {}
    for view in progress(sheet_views(run.data(SHEETS), every), 'sheets'):
        if view.number == PHOTOGRAPH:
            name = 'image00.jpg'
        elif view.number % MEASURED_EVERY == 0:
            continue
        else:
            name = 'movie.mp4' if view.is_visible else 'movie.mp4, a corner covered'
        groups.setdefault(name, []).append(bench.trial(view, generator))
    heads = 'pictures | views | right / none / wrong | error mm: median / 95 % / max | heading °: the same'
    table = run.table('Printed sheets', heads, 'no pose with the sheet left out of the map')
    for name, trials in groups.items():
        without = rate(sum(trial.without_it == 'none' for trial in trials), len(trials))
        table.add(name, len(trials), *trial_cells(trials, '.2f'), without)


def add_terrazzo(run: Run, views: int) -> None:
    """Add what became of the views."""
    picture = np.asarray(cv2.imread(str(run.data(*TERRAZZO))), dtype=np.uint8)
    heads = 'polarity | right / none / wrong | error mm: median / 95 % / max | heading °: the same'
    table = run.table('Views of terrazzo', heads, 'match rate: rms')
    for polarity in ('auto', 'dark', 'any'):
        detector = DotDetector(DotDetectorSettings(polarity=polarity))
        trials = list(progress(terrazzo_trials(picture, detector, views, run.seed), polarity, views))
        match_rate = rms([trial.match_rate for trial in trials], '.2f', better='higher')
        table.add(polarity, *trial_cells(trials, '.3f'), match_rate)


def trial_cells(trials: list[Trial], form: str) -> tuple[Figure, Figure, Figure]:
    """Return three cells: right / none / wrong, and errors of position [mm] and heading [°]."""
    turns = error([trial.turn for trial in trials], form, math.degrees(1.0))
    verdicts = outcomes(trial.outcome for trial in trials)
    return verdicts, error([trial.error for trial in trials], form, 1e3), turns


def main(run: Run, every: int, views: int) -> None:
    """Locate sheets and terrazzo."""
    add_sheets(run, every)
    add_terrazzo(run, views)


if __name__ == '__main__':
    run_benchmark(
        main,
        every=Option(1, 21, 'use every n-th frame of the movie'),
        views=Option(1000, 40, 'views to cut from the terrazzo'),
    )
