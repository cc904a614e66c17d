"""The paper's tables 1 to 5 again, on its conditions, with its figures: by the localizer, and by the pole star.

The pole star, the paper's own method without the suite's acceptance, is run at every twentieth place.
"""

import math
from collections import Counter
from collections.abc import Callable, Iterator
from functools import cache
from typing import NamedTuple

import numpy as np
from _figures import percent, time
from _harness import Option, Run, cpu_time, in_processes, run_benchmark
from _paper_matchers import (
    Candidates,
    Matcher,
    constellation,
    constellation_candidates,
    indexed,
    pole_star,
    pole_star_candidates,
)
from _paper_views import NOISE, PaperView, paper_floor, paper_views, spread_places
from _pose_scores import PoseScore, pose_cells, score_found, verdict_of
from numpy.typing import NDArray

RATES = (0.1, 0.2, 0.3, 0.4, 0.5)


class Cell(NamedTuple):
    """One column of a table of the paper: rates of missing and spurious dots, or numbers of right and spurious ones."""

    missing: float
    spurious: float
    paper: str
    noise: float = NOISE
    dots: tuple[int, int] | None = None


# Right / wrong / none in percent.
PAPER = {
    '2': ('100 / 0 / 0', '100 / 0 / 0', '100 / 0 / 0', '99.59 / 0.33 / 0.08', '99.26 / 0.66 / 0.08'),
    '3': (*('100 / 0 / 0', '99.92 / 0 / 0.08', '99.59 / 0.17 / 0.29'), *('99.5 / 0.08 / 0.41', '95.95 / 0.91 / 3.14')),
    '4': (
        *('99.57 / 0.08 / 0.33', '98.76 / 0.50 / 0.74', '97.35 / 1.41 / 1.24'),
        *('95.54 (sums up with 94.54) / 3.39 / 2.07', '89.66 / 7.44 / 2.90'),
    ),
}
# Table 5: lowest match rate of a right pose, highest of a wrong one.
MATCH_RATES = ('61.1 / 10.0', '56.3 / 16.1', '51.5 / 23.5', '38.9 / 18.9', '42.9 / 21.4')
# Table 1: photographs with dots that were added or hidden; rates, and right and spurious dots that they mean.
PHOTOGRAPHED = {
    'found (fig. 27: 37 right + 25 spurious of 41)': (0.098, 0.610, (37, 25)),
    'failed (fig. 28: 35 + 37 of 41)': (0.146, 0.902, (35, 37)),
    'found (fig. 29: 10 + 4 of 42)': (0.762, 0.095, (10, 4)),
    'failed (fig. 30: 8 + 4 of 42)': (0.810, 0.095, (8, 4)),
    'found (fig. 31: 11 + 4 of 51)': (0.784, 0.078, (11, 4)),
}
TABLES = {
    '1': [
        Cell(missing, spurious, paper, noise, dots)
        for noise in (NOISE, 0.3)
        for paper, (missing, spurious, dots) in PHOTOGRAPHED.items()
    ],
    '2': [Cell(0.0, rate, paper) for rate, paper in zip(RATES, PAPER['2'], strict=True)],
    '3': [Cell(rate, 0.0, paper) for rate, paper in zip(RATES, PAPER['3'], strict=True)],
    '4': [Cell(0.25, rate, paper) for rate, paper in zip(RATES, PAPER['4'], strict=True)],
    '5': [Cell(0.25, rate, paper) for rate, paper in zip(RATES, MATCH_RATES, strict=True)],
}
MATCHERS: dict[str, Callable[[NDArray[np.float64]], Matcher]] = {
    'constellation': lambda floor: constellation(indexed(floor)),
    'pole_star': pole_star,
}
CANDIDATES: dict[str, Callable[[NDArray[np.float64]], Candidates]] = {
    'constellation': constellation_candidates,
    'pole_star': pole_star_candidates,
}
POLE_STAR_EVERY = 20  # places of which the pole star, which takes a second for each, is run at one


class Task(NamedTuple):
    """One view to be scored, for another process."""

    matcher: str
    seed: int
    view: PaperView
    noise: float


@cache
def _matcher(name: str, seed: int) -> Matcher:
    """Return this process's matcher, its database built and its kernels compiled."""
    floor = paper_floor(seed)
    locate = MATCHERS[name](floor)
    for view in paper_views(floor, spread_places(2), 0.5, 0.5, seed):
        locate(view.pixels)
    return locate


def score(task: Task) -> PoseScore:
    """Score one view with this process's matcher."""
    locate = _matcher(task.matcher, task.seed)
    answer, milliseconds = cpu_time(locate, task.view.pixels, task.noise)
    return score_found(answer.T_map_view, task.view.T_map_view, reason=answer.reason, milliseconds=milliseconds)


@cache
def _candidates(name: str, seed: int) -> Candidates:
    return CANDIDATES[name](paper_floor(seed))


def match_rates(task: Task) -> tuple[float, float]:
    """Return the highest match rates of a right and of a wrong pose of a view, accepted or not."""
    found = _candidates(task.matcher, task.seed)(task.view.pixels)
    rates = {'right': [math.nan], 'wrong': [0.0]}
    for pose, rate in found:
        rates[verdict_of(pose, task.view.T_map_view)].append(rate)
    return max(rates['right'][1:], default=math.nan), max(rates['wrong'])


def tasks(matcher: str, table: str, places: int, seed: int) -> Iterator[Task]:
    """Yield all views of a table in order."""
    floor = paper_floor(seed)
    for cell in TABLES[table]:
        chosen = spread_places(places)
        for view in paper_views(floor, chosen, cell.missing, cell.spurious, seed, cell.noise, cell.dots):
            yield Task(matcher, seed, view, cell.noise)


def add_table(run: Run, name: str, table: str, by_cell: list[list[PoseScore]]) -> None:
    """Add one of the tables 1 to 4."""
    heads = 'missing % | spurious % | noise px | right / none / wrong | the paper: right / wrong / none %'
    found = run.table(name, heads, 'error mm: median / 95 % / max | error °: the same | time ms: the same')
    for cell, scores in zip(TABLES[table], by_cell, strict=True):
        verdicts, *errors = pose_cells(scores, '.2f', '.2f', shown=(50, 95, 100))
        times = time([score.milliseconds for score in scores], '.1f', (50, 95, 100))
        rates = percent(cell.missing), percent(cell.spurious), f'{cell.noise:g}'
        found.add(*rates, verdicts, cell.paper, *errors, times)
    reasons = Counter(score.reason for scores in by_cell for score in scores if score.reason)
    if reasons:
        counts = ', '.join(f'{number} x "{reason}"' for reason, number in reasons.most_common())
        run.note(f'No pose: {counts}')


def add_match_rates(run: Run, name: str, by_cell: list[list[tuple[float, float]]]) -> None:
    """Add table 5 for one matcher."""
    heads = 'missing % | spurious % | views with the right pose | lowest right / highest wrong % | the paper'
    table = run.table(name, heads)
    for cell, rates in zip(TABLES['5'], by_cell, strict=True):
        right, wrong = np.array(rates).T
        shown = f'{100.0 * np.nanmin(right):.1f} / {100.0 * wrong.max():.1f}'
        found = f'{np.isfinite(right).sum()} of {len(right)}'
        table.add(percent(cell.missing), percent(cell.spurious), found, shown, cell.paper)


def main(run: Run, matchers: tuple[str, ...], tables: tuple[str, ...], places: int) -> None:
    """Run the tables that are asked for."""
    for matcher in matchers:
        count = max(places // POLE_STAR_EVERY, 1) if matcher == 'pole_star' else places
        for table in tables:
            name = f'Table {table}' + (', pole star' if matcher == 'pole_star' else '')
            wanted, views = list(tasks(matcher, table, count, run.seed)), len(spread_places(count))
            starts = range(0, views * len(TABLES[table]), views)
            if table == '5':
                rates = in_processes(match_rates, wanted, name)
                add_match_rates(run, name, [rates[k : k + views] for k in starts])
            else:
                scores = in_processes(score, wanted, name)
                add_table(run, name, table, [scores[k : k + views] for k in starts])


if __name__ == '__main__':
    run_benchmark(
        main,
        matchers=Option(tuple(MATCHERS), tuple(MATCHERS), 'of the tables'),
        tables=Option(tuple(TABLES), tuple(TABLES), 'of the paper'),
        places=Option(1209, 20, 'most views of a cell'),
    )
