"""100 000 views of the right floor, of other floors, of dust, mirrored and of a wrong scale: is a pose ever wrong?

    shirube bench wrong_poses
    shirube bench wrong_poses --share 0.05 --effort 1

The floor and the views are those of the paper (3.3.1) at random places. Without an option a view that matches
nowhere takes the effort that the tracker allows it while images keep coming; ``--effort 1`` takes all that the
settings allow, as ``locate`` does for a single image, some twenty times as long.
"""

from __future__ import annotations

import argparse
import multiprocessing
import os
from collections import Counter
from functools import cache
from typing import NamedTuple

import numpy as np
from _paper_matchers import DOT_DIAMETER
from _paper_scores import RIGHT_TURN, RIGHT_WITHIN
from _paper_views import CAMERA, FLOOR_SIZE, MOUNT, NOISE, VIEW_SIZE, PaperView, paper_floor, paper_views
from numpy.typing import NDArray
from tqdm import tqdm

from floor_localizer.core.constellation.indexed_map import index_map
from floor_localizer.core.dots import DetectedDots, DotMap
from floor_localizer.core.fix import Fix
from floor_localizer.core.localizer import FloorLocalizer
from floor_localizer.core.settings import TrackerSettings

FLOOR_SEED = 1
OTHER_FLOORS = 10
DUST = (5, 90)
"""Fewest and most spots in a view of dust."""
BATCH = 100


class ViewKind(NamedTuple):
    """One kind of view.

    Attributes:
        name: description for the table.
        views: how many.
        missing: share of the dots that is missing.
        spurious: spurious dots as a share of the dots.
        other_floor: whether the floor is not that of the map.
        mirrored: whether the image is mirrored.
        scale: scale of the image relative to the camera's.
    """

    name: str
    views: int
    missing: float = 0.0
    spurious: float = 0.0
    other_floor: bool = False
    mirrored: bool = False
    scale: float = 1.0


DUST_ALONE = 'dust alone'
KINDS = (
    ViewKind('the right floor, clean', 20000),
    ViewKind('25 % missing, 30 % spurious', 10000, 0.25, 0.3),
    ViewKind('25 % missing, 50 % spurious', 10000, 0.25, 0.5),
    ViewKind('another floor', 10000, other_floor=True),
    ViewKind('another floor, 25 % missing, 30 % spurious', 10000, 0.25, 0.3, other_floor=True),
    ViewKind(DUST_ALONE, 20000),
    ViewKind('mirrored', 10000, mirrored=True),
    ViewKind('10 % too large', 5000, scale=1.1),
    ViewKind('10 % too small', 5000, scale=0.9),
)


class Batch(NamedTuple):
    """Views of a kind, for another process."""

    kind: ViewKind
    number: int
    views: int
    effort: float


def views_of(batch: Batch) -> list[PaperView]:
    """Make the views of a batch; the same batch is always the same."""
    kind, rng = batch.kind, np.random.default_rng([7, KINDS.index(batch.kind), batch.number])
    margin = VIEW_SIZE / np.sqrt(2.0)
    places = rng.uniform(margin, np.array(FLOOR_SIZE) - margin, (batch.views, 2))
    floor_seed = FLOOR_SEED + (1 + batch.number % OTHER_FLOORS if kind.other_floor else 0)
    return list(
        paper_views(floor_of(floor_seed), places, kind.missing, kind.spurious, int(rng.integers(1 << 30)))
    )


def pixels_of(kind: ViewKind, view: PaperView, rng: np.random.Generator) -> NDArray[np.float64]:
    """Return what the camera sees of a view, shape (n, 2) [px]."""
    if kind.name == DUST_ALONE:
        return rng.uniform(-0.5, CAMERA.width - 0.5, (int(rng.integers(DUST[0], DUST[1] + 1)), 2))
    centre = np.array([CAMERA.cx, CAMERA.cy])
    sides = np.array([-1.0 if kind.mirrored else 1.0, 1.0])
    return centre + (view.pixels - centre) * sides * kind.scale


def run_batch(batch: Batch) -> Counter[str]:
    """Count right, wrong and, by its reason, no pose."""
    localizer, rng = localizer_of_process(), np.random.default_rng([8, batch.number])
    counts: Counter[str] = Counter()
    for view in views_of(batch):
        pixels = pixels_of(batch.kind, view, rng)
        diameters = np.full(len(pixels), DOT_DIAMETER / MOUNT.xyz[2] * CAMERA.fx)
        dots = DetectedDots(pixels, diameters, np.full(len(pixels), NOISE))
        found = localizer.locate_dots(dots, CAMERA, effort=batch.effort)
        if isinstance(found, Fix):
            counts['right' if is_right(batch.kind, found, view) else 'wrong'] += 1
        else:
            counts[found.reason.value] += 1
    return counts


def is_right(kind: ViewKind, fix: Fix, view: PaperView) -> bool:
    """Return whether a pose is that of the view; of another floor, of dust and of a mirror image there is none."""
    if kind.other_floor or kind.mirrored or kind.name == DUST_ALONE:
        return False
    pose, truth = fix.T_map_base, view.T_map_view
    return pose.distance_to(truth) <= RIGHT_WITHIN and abs(pose.yaw_to(truth)) <= RIGHT_TURN


@cache
def floor_of(seed: int) -> NDArray[np.float64]:
    """Return this process's copy of a floor, shape (N, 2) [m]."""
    return paper_floor(seed)


@cache
def localizer_of_process() -> FloorLocalizer:
    """Return this process's localizer."""
    floor = floor_of(FLOOR_SEED)
    return FloorLocalizer(index_map(DotMap(floor, np.full(len(floor), np.nan))), MOUNT)


def print_table(counts: dict[ViewKind, Counter[str]]) -> None:
    """Print a line a kind and the sum of all."""
    print('| views | number | right | wrong | none | why none |\n|---|---|---|---|---|---|')
    for kind, count in counts.items():
        total, right, wrong = count.total(), count['right'], count['wrong']
        reasons = ', '.join(
            f'{number} x {reason}'
            for reason, number in count.most_common()
            if reason not in ('right', 'wrong')
        )
        share = f' ({100.0 * right / total:.2f} %)' if right else ''
        print(f'| {kind.name} | {total} | {right}{share} | {wrong} | {total - right - wrong} | {reasons} |')
    everything = sum(counts.values(), Counter())
    print(f'\nWrong in all {everything.total()} views: {everything["wrong"]}.')


def main() -> None:
    """Look at the views in all processes and print the table."""
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument('--share', type=float, default=1.0, help='share of the views, for a quick look')
    parser.add_argument(
        '--effort',
        type=float,
        default=TrackerSettings().usual_effort,
        help='share of cells_max and pairs_max',
    )
    parser.add_argument('--processes', type=int, default=os.cpu_count())
    arguments = parser.parse_args()
    os.environ['OPENBLAS_NUM_THREADS'] = '1'
    batches = [
        Batch(kind, number, min(BATCH, round(arguments.share * kind.views) - start), arguments.effort)
        for kind in KINDS
        for number, start in enumerate(range(0, round(arguments.share * kind.views), BATCH))
    ]
    counts: dict[ViewKind, Counter[str]] = {kind: Counter() for kind in KINDS}
    with (
        multiprocessing.get_context('spawn').Pool(arguments.processes) as pool,
        tqdm(total=sum(batch.views for batch in batches), unit='view') as bar,
    ):
        for batch, count in zip(batches, pool.imap(run_batch, batches), strict=True):
            counts[batch.kind] += count
            bar.update(batch.views)
    print_table(counts)


if __name__ == '__main__':
    main()
