"""The paper's tables 2 to 5 and its two failed cases again, on its conditions, with its figures.

    shirube bench paper_tables --matcher constellation
    shirube bench paper_tables --matcher pole_star --places 100 --tables 4

Table 5 compares the paper's match rate (2.3.3) of right poses with that of the best wrong candidate over the
cells of table 4. Wrong candidates are the poses of the pole-star pipeline more than 20 mm from the truth,
taken or not, at every tenth place; the paper counts only those that were taken.
"""

from __future__ import annotations

import argparse
import multiprocessing
import os
from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np
from _paper_matchers import MATCHERS
from _paper_report import TABLES, Cell, print_chance, print_table, print_table_5
from _paper_scores import Score, scorer
from _paper_views import PaperView, paper_floor, paper_places, paper_views
from numpy.typing import NDArray
from tqdm import tqdm

# The pole-star pipeline, which names the wrong candidates, takes most of the time: it is asked this seldom.
RUNNERS_UP_EVERY = 10


@dataclass(frozen=True)
class Task:
    """One view to be scored, for another process."""

    matcher: str
    seed: int
    view: PaperView
    with_runners_up: bool


def score(task: Task) -> Score:
    """Score one view with this process's matcher."""
    return scorer(task.matcher, task.seed).score(task.view, with_runners_up=task.with_runners_up)


def tasks(matcher: str, tables: list[str], places_max: int, seed: int) -> Iterator[Task]:
    """Yield all views of the tables in order."""
    floor = paper_floor(seed)
    for table in tables:
        for cell in TABLES[table]:
            views = paper_views(floor, places_of(cell, places_max), cell.missing, cell.spurious, seed)
            for number, view in enumerate(views):
                yield Task(matcher, seed, view, table == '4' and number % RUNNERS_UP_EVERY == 0)


def places_of(cell: Cell, places_max: int) -> NDArray[np.float64]:
    """Return the places of a cell, spread over the whole grid if these are not all, shape (p, 2) [m]."""
    places = paper_places()
    count = min(cell.places, places_max)
    return places[np.linspace(0, len(places) - 1, count).round().astype(np.intp)]


def main() -> None:
    """Run the tables that are asked for."""
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument('--matcher', choices=sorted(MATCHERS), default='constellation')
    parser.add_argument(
        '--tables', nargs='+', choices=sorted(TABLES), default=list(TABLES), help='4 includes 5'
    )
    parser.add_argument('--places', type=int, default=1209, help='most views of a cell, for a quick look')
    parser.add_argument('--processes', type=int, default=os.cpu_count())
    parser.add_argument('--seed', type=int, default=1)
    arguments = parser.parse_args()
    # The processes fill the cores, so a thread each; the children read this when they import numpy.
    os.environ['OPENBLAS_NUM_THREADS'] = '1'
    tables = sorted(arguments.tables)
    work = list(tasks(arguments.matcher, tables, arguments.places, arguments.seed))
    with multiprocessing.get_context('spawn').Pool(arguments.processes) as pool:
        scores = iter(list(tqdm(pool.imap(score, work, chunksize=4), total=len(work), unit='view')))
    print(f'\n## {arguments.matcher}, seed {arguments.seed}')
    for table in tables:
        by_cell = [[next(scores) for _ in places_of(cell, arguments.places)] for cell in TABLES[table]]
        print_table(table, by_cell)
        if table == '4':
            print_table_5(by_cell)
        if table == 'failed':
            print_chance(TABLES[table][1], by_cell[1])


if __name__ == '__main__':
    main()
