"""100 000 views of the right floor, of other floors, of dust, mirrored and of a wrong scale: is a pose ever wrong?

The floor and the views are those of the paper (3.3.1) at random places. A view that matches nowhere takes the effort
that the tracker allows it while images keep coming; ``--effort 1`` takes all that the settings allow, as ``locate``
does for a single image, some twenty times as long.
"""

from collections import Counter
from functools import cache
from typing import NamedTuple

import numpy as np
from _figures import rate
from _harness import Option, Run, in_processes, run_benchmark
from _paper_matchers import detected, indexed
from _paper_views import CAMERA, FLOOR_SIZE, MOUNT, VIEW_SIZE, PaperView, paper_floor, paper_views
from _pose_scores import verdict_of
from numpy.typing import NDArray

from floor_localizer.core.fix import Fix
from floor_localizer.core.localizer import FloorLocalizer
from floor_localizer.core.settings import TrackerSettings

FLOOR_SEED = 1
OTHER_FLOORS = 10
DUST = (5, 90)  # fewest and most spots in a view of dust
BATCH = 100
USUAL_EFFORT = TrackerSettings().usual_effort


class ViewKind(NamedTuple):
    """One kind of view: name, number, rates of missing and spurious dots, and what is wrong with it."""

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
    floor = _floor(FLOOR_SEED + (1 + batch.number % OTHER_FLOORS if kind.other_floor else 0))
    return list(paper_views(floor, places, kind.missing, kind.spurious, int(rng.integers(1 << 30))))


def pixels_of(kind: ViewKind, view: PaperView, rng: np.random.Generator) -> NDArray[np.float64]:
    """Return what the camera sees of a view, shape (n, 2) [px]."""
    if kind.name == DUST_ALONE:
        return rng.uniform(-0.5, CAMERA.width - 0.5, (int(rng.integers(DUST[0], DUST[1] + 1)), 2))
    centre = np.array([CAMERA.cx, CAMERA.cy])
    sides = np.array([-1.0 if kind.mirrored else 1.0, 1.0])
    return centre + (view.pixels - centre) * sides * kind.scale


def run_batch(batch: Batch) -> Counter[str]:
    """Count right, wrong and, by its reason, no pose; any pose of another floor, dust or a mirror image is wrong."""
    localizer, rng, kind = _localizer(), np.random.default_rng([8, batch.number]), batch.kind
    has_pose = not (kind.other_floor or kind.mirrored or kind.name == DUST_ALONE)
    counts: Counter[str] = Counter()
    for view in views_of(batch):
        found = localizer.locate_dots(detected(pixels_of(kind, view, rng)), CAMERA, effort=batch.effort)
        if isinstance(found, Fix):
            counts[verdict_of(found.T_map_base, view.T_map_view) if has_pose else 'wrong'] += 1
        else:
            counts[found.reason.value] += 1
    return counts


_floor = cache(paper_floor)


@cache
def _localizer() -> FloorLocalizer:
    return FloorLocalizer(indexed(_floor(FLOOR_SEED)), MOUNT)


def main(run: Run, share: float, effort: float) -> None:
    """Look at the views in all processes."""
    batches = [
        Batch(kind, number, min(BATCH, round(share * kind.views) - start), effort)
        for kind in KINDS
        for number, start in enumerate(range(0, round(share * kind.views), BATCH))
    ]
    counts = {kind: Counter[str]() for kind in KINDS}
    for batch, found in zip(batches, in_processes(run_batch, batches), strict=True):
        counts[batch.kind] += found
    counts[ViewKind('all', 0)] = sum(counts.values(), Counter())
    table = run.table('Wrong poses', 'views', 'right', 'wrong', 'why none')
    for kind, found in counts.items():
        reasons = [f'{n} x {reason}' for reason, n in found.most_common() if reason not in {'right', 'wrong'}]
        right, wrong = rate(found['right'], found.total()), rate(found['wrong'], found.total(), 'lower')
        table.add(kind.name, right, wrong, ', '.join(reasons) if kind.views else '')


if __name__ == '__main__':
    run_benchmark(
        main,
        share=Option(1.0, 0.01, 'of the views'),
        effort=Option(USUAL_EFFORT, USUAL_EFFORT, 'of cells_max and pairs_max'),
    )
