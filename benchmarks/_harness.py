"""One harness for all benchmarks: arguments, tables of figures, timing, peers, progress, JSON.

A benchmark is a program whose ``main(run, ...)`` fills tables::

    def main(run: Run, views: int) -> None:
        table = run.table('Errors', 'method | views | error mm: median / 95 % / max')
        table.add('ours', views, error(samples, scale=1e3))


    if __name__ == '__main__':
        run_benchmark(main, views=Option(400, 20, 'of each condition'))
"""

import argparse
import os
import resource
import sys
import time
from collections.abc import Callable, Iterable, Iterator, Sequence
from dataclasses import dataclass, field
from importlib import import_module
from multiprocessing import get_context
from pathlib import Path
from typing import Any, TypeVar

import cv2
import numpy as np
from _figures import Figure
from _results import Cell, compare_with_saved, format_table, machine, save, write_json
from tqdm import tqdm

Item = TypeVar('Item')
Result = TypeVar('Result')


class MissingError(Exception):
    """What a benchmark needs is not here."""


@dataclass(frozen=True)
class Option:
    """An argument: its default, that of a quick run, and what it is."""

    default: Any
    quick: Any
    help: str


@dataclass
class Table:
    """A table under construction; the first cells of a row that are text are its name."""

    name: str
    heads: Sequence[str]
    rows: list[list[Cell]] = field(default_factory=list)

    def add(self, *cells: object) -> None:
        """Add a row."""
        if len(cells) != len(self.heads):
            raise ValueError(f'{self.name}: {len(cells)} cells for {len(self.heads)} heads')
        self.rows.append([cell if isinstance(cell, Figure) else str(cell) for cell in cells])


class Run:
    """One run of a benchmark: its random seed, tables and notes."""

    def __init__(self, seed: int) -> None:
        self.seed = seed
        self.tables: list[Table] = []
        self.notes: list[str] = []

    def table(self, name: str, *heads: str) -> Table:
        """Begin a table; heads may be given in one text, separated as in Markdown."""
        self.tables.append(Table(name, ' | '.join(heads).split(' | ')))
        return self.tables[-1]

    def note(self, text: str) -> None:
        """Say something below the tables."""
        self.notes.append(text)

    def data(self, *parts: str) -> Path:
        """Return a file or folder of real data.

        Raises:
            MissingError: it is not there.
        """
        path = Path(os.environ.get('SHIRUBE_DATA', 'not given')).joinpath(*parts)
        if not path.exists():
            raise MissingError(f'SHIRUBE_DATA names no folder with {"/".join(parts)}')
        return path

    def peer(self, module: str, install: str) -> Any:
        """Return the module of a peer, None where it is not installed."""
        try:
            return import_module(module)
        except ImportError:
            text = f'Not compared with {module}: `pip install {install}`'
            if text not in self.notes:
                self.note(text)
            return None


def progress(items: Iterable[Item], name: str = '', total: int | None = None) -> Iterator[Item]:
    """Yield items, with a bar on a terminal."""
    yield from tqdm(items, name, total, leave=False, disable=not sys.stderr.isatty())


def use_one_core() -> None:
    """Keep this process on one core."""
    if hasattr(os, 'sched_setaffinity'):
        os.sched_setaffinity(0, {max(os.sched_getaffinity(0))})
    cv2.setNumThreads(1)


def cpu_time(call: Callable[..., Result], *arguments: Any) -> tuple[Result, float]:
    """Return what a call returns and its processor time [ms]."""
    begin = time.process_time()
    result = call(*arguments)
    return result, 1e3 * (time.process_time() - begin)


def children_cpu_seconds() -> float:
    """Return the processor time of ended child processes [s]."""
    used = resource.getrusage(resource.RUSAGE_CHILDREN)
    return used.ru_utime + used.ru_stime


def side_by_side(jobs: dict[str, Callable[[], object]], rounds: int) -> dict[str, list[float]]:
    """Return the processor times of jobs [ms], in a new random order in each round; the first round compiles."""
    times: dict[str, list[float]] = {name: [] for name in jobs}
    rng = np.random.default_rng(0)
    for k in progress(range(-1, rounds), 'rounds'):
        for name in rng.permutation(list(jobs)):
            milliseconds = cpu_time(jobs[name])[1]
            if k >= 0:
                times[name].append(milliseconds)
    return times


def in_processes(function: Callable[[Item], Result], items: Sequence[Item], name: str = '') -> list[Result]:
    """Return a function's results in order, computed on all cores; it must be importable."""
    with get_context('spawn').Pool(os.cpu_count()) as pool:
        return list(progress(pool.imap(function, items, chunksize=4), name, len(items)))


def run_benchmark(main: Callable[..., None], **options: Option) -> None:
    """Run a benchmark as a program; exits with 1 when something is worse than the saved result."""
    program = sys.modules['__main__']
    name = Path(str(program.__file__)).stem
    parser = argparse.ArgumentParser(
        prog=name, description=program.__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument('--quick', action='store_true', help='a look within seconds')
    parser.add_argument('--seed', type=int, default=1)
    kept = f'benchmarks/results/{name}.json'
    parser.add_argument('--save', action='store_true', help=f'keep the result in {kept}')
    parser.add_argument('--compare', action='store_true', help=f'print what changed since {kept}')
    for key, option in options.items():
        _add(parser, key, option)
    given = parser.parse_args()
    arguments = {key: option.quick if given.quick else option.default for key, option in options.items()}
    arguments |= {key: value for key, value in vars(given).items() if key in options and value is not None}
    run, begin = Run(given.seed), time.perf_counter()
    try:
        main(run, **arguments)
    except MissingError as missing:
        print(f'skipped: {missing}')
        return
    finally:
        _print(run)
    found = {
        'benchmark': name,
        **machine(),
        'arguments': {'seed': given.seed, **arguments},
        'seconds': round(time.perf_counter() - begin, 1),
        'tables': run.tables,
        'notes': run.notes,
    }
    write_json(found)
    worse = compare_with_saved(found, quick=given.quick) if given.compare else 0
    if given.save:
        save(found, quick=given.quick)
    if worse:
        raise SystemExit(1)


def _add(parser: argparse.ArgumentParser, key: str, option: Option) -> None:
    flag = f'--{key.replace("_", "-")}'
    text = f'{option.help} (default: {option.default}, quick: {option.quick})'.replace('%', '%%')
    if isinstance(option.default, bool):
        parser.add_argument(flag, action=argparse.BooleanOptionalAction, default=None, help=option.help)
    elif isinstance(option.default, tuple):
        kind = type(option.default[0])
        parser.add_argument(flag, type=kind, nargs='+', help=text)
    else:
        parser.add_argument(flag, type=type(option.default), help=text)


def _print(run: Run) -> None:
    for table in run.tables:
        if table.rows:
            print(f'\n### {table.name}\n\n{format_table(table.heads, table.rows)}')
    for note in run.notes:
        print(f'\n{note}')
