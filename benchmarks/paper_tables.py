"""The paper's tables 2 to 4 and its two failed cases again, on its conditions, with its figures."""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterator
from functools import cache
from typing import NamedTuple

from _figures import percent, time
from _harness import Option, Run, cpu_time, in_processes, run_benchmark
from _paper_matchers import Matcher, constellation, indexed
from _paper_views import PaperView, paper_floor, paper_views, spread_places
from _pose_scores import PoseScore, pose_cells, score_found

RATES = (0.1, 0.2, 0.3, 0.4, 0.5)


class Cell(NamedTuple):
    """One column of a table of the paper: rates of missing and spurious dots, its figures, and ours to find."""

    missing: float
    spurious: float
    paper: str
    places: int = 1209


# Right / wrong / none in percent. The paper prints 95.54 at 40 % in table 4; its row adds up with 94.54.
PAPER = {
    '2': ('100 / 0 / 0', '100 / 0 / 0', '100 / 0 / 0', '99.59 / 0.33 / 0.08', '99.26 / 0.66 / 0.08'),
    '3': (
        *('100 / 0 / 0', '99.92 / 0 / 0.08', '99.59 / 0.17 / 0.29'),
        *('99.5 / 0.08 / 0.41', '95.95 / 0.91 / 3.14'),
    ),
    '4': (
        *('99.57 / 0.08 / 0.33', '98.76 / 0.50 / 0.74', '97.35 / 1.41 / 1.24'),
        *('94.54 / 3.39 / 2.07', '89.66 / 7.44 / 2.90'),
    ),
}
TABLES = {
    '2': [Cell(0.0, rate, paper) for rate, paper in zip(RATES, PAPER['2'], strict=True)],
    '3': [Cell(rate, 0.0, paper) for rate, paper in zip(RATES, PAPER['3'], strict=True)],
    '4': [Cell(0.25, rate, paper) for rate, paper in zip(RATES, PAPER['4'], strict=True)],
    'failed': [Cell(0.146, 0.902, 'failed (fig. 28)', 1000), Cell(0.81, 0.095, 'failed (fig. 30)', 1000)],
}


class Task(NamedTuple):
    """One view to be scored, for another process."""

    seed: int
    view: PaperView


@cache
def _matcher(seed: int) -> Matcher:
    """Return this process's matcher, its database built and its kernels compiled."""
    floor = paper_floor(seed)
    locate = constellation(indexed(floor))
    for view in paper_views(floor, spread_places(2), 0.5, 0.5, seed):
        locate(view.pixels)
    return locate


def score(task: Task) -> PoseScore:
    """Score one view with this process's matcher."""
    answer, milliseconds = cpu_time(_matcher(task.seed), task.view.pixels)
    return score_found(
        answer.T_map_view, task.view.T_map_view, reason=answer.reason, milliseconds=milliseconds
    )


def tasks(table: str, places: int, seed: int) -> Iterator[Task]:
    """Yield all views of a table in order."""
    floor = paper_floor(seed)
    for cell in TABLES[table]:
        chosen = spread_places(min(places, cell.places))
        for view in paper_views(floor, chosen, cell.missing, cell.spurious, seed):
            yield Task(seed, view)


def add_table(run: Run, table: str, by_cell: list[list[PoseScore]]) -> None:
    """Add one of the tables 2, 3, 4 or the failed cases."""
    heads = 'missing % | spurious % | right / none / wrong | the paper: right / wrong / none %'
    name = 'The failed cases' if table == 'failed' else f'Table {table}'
    found = run.table(name, heads, 'error mm: median / 95 % / max | error °: the same | time ms: the same')
    for cell, scores in zip(TABLES[table], by_cell, strict=True):
        verdicts, *errors = pose_cells(scores, '.2f', '.2f', shown=(50, 95, 100))
        times = time([score.milliseconds for score in scores], '.1f', (50, 95, 100))
        found.add(percent(cell.missing), percent(cell.spurious), verdicts, cell.paper, *errors, times)
    reasons = Counter(score.reason for scores in by_cell for score in scores if score.reason)
    if reasons:
        counts = ', '.join(f'{number} x "{reason}"' for reason, number in reasons.most_common())
        run.note(f'No pose: {counts}')


def main(run: Run, tables: tuple[str, ...], places: int) -> None:
    """Run the tables that are asked for."""
    for table in tables:
        scores = iter(in_processes(score, list(tasks(table, places, run.seed)), f'table {table}'))
        by_cell = [[next(scores) for _ in range(min(places, cell.places))] for cell in TABLES[table]]
        add_table(run, table, by_cell)


if __name__ == '__main__':
    run_benchmark(
        main,
        tables=Option(tuple(TABLES), tuple(TABLES), 'of the paper'),
        places=Option(1209, 20, 'most views of a cell'),
    )
