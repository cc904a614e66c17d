"""Halls of up to 10^8 dots: what their index costs, and the time to a fix without a prior, warm and cold.

    shirube bench large_floors
    shirube bench large_floors --dots 100000000 --folder /data/hall --workers 2

Each hall is written as CSV, indexed by ``index_map`` and asked in a process of its own. Times to build and to a fix are
processor time, in units of the first hall's as well; opening and cold fixes are by the clock: for these the file is
put out of the page cache before each view. 10^8 dots take 25 GB of disk while they are indexed, and an hour; a build
that was stopped goes on, and a map that is there is used again.
"""

from __future__ import annotations

import argparse
import os
import resource
import subprocess
import sys
import tempfile
import time
from concurrent.futures import ProcessPoolExecutor
from dataclasses import dataclass
from multiprocessing import get_context
from pathlib import Path

import numpy as np
from _hall import Hall
from _paper_matchers import constellation_of
from _paper_views import VIEW_SIZE, PaperView, paper_views
from _timed_answers import TimedAnswer, outcome_rates, time_answer, time_quantiles, use_one_core
from numpy.typing import NDArray

from floor_localizer.files.dot_map_file import load_indexed_map
from shirube_core.geometry import SE2

CONDITIONS = ((0.25, 0.3), (0.25, 0.5))
_BLOCK = 1 << 24


@dataclass(frozen=True)
class Measured:
    """What one hall came to.

    Attributes:
        dots: number of dots in the hall.
        file_bytes: size of its map.
        build_seconds: processor time of ``index_map``, NaN where the map was there.
        open_milliseconds: time to open the map.
        private_bytes: memory of the process that answered, without what it maps of files.
        warm: answers with the file in the page cache, for each condition.
        cold: answers without, under the first condition.
        cold_reads: pages read from the disk for each of these.
    """

    dots: int
    file_bytes: int
    build_seconds: float
    open_milliseconds: float
    private_bytes: int
    warm: list[list[TimedAnswer]]
    cold: list[TimedAnswer]
    cold_reads: list[int]


def build(hall: Hall, path: Path, workers: int) -> float:
    """Write a hall and index it; return the processor time of the index [s]."""
    if path.exists():
        return float('nan')
    source = path.with_suffix('.csv')
    if not source.exists():
        written = source.with_suffix('.written')
        hall.write(written)
        written.replace(source)
    before = resource.getrusage(resource.RUSAGE_CHILDREN)
    command = [sys.executable, '-m', 'floor_localizer.commands.index_map', str(source), '--out', str(path)]
    subprocess.run([*command, '--workers', str(workers)], check=True)
    after = resource.getrusage(resource.RUSAGE_CHILDREN)
    source.unlink()
    return after.ru_utime - before.ru_utime + after.ru_stime - before.ru_stime


def views_of(hall: Hall, number: int, missing: float, spurious: float) -> list[PaperView]:
    """Return views all over a hall."""
    views: list[PaperView] = []
    for k, place in enumerate(hall.places(number, VIEW_SIZE)):
        floor = hall.around(float(place[0]), float(place[1]), VIEW_SIZE)
        views += paper_views(floor, place[None, :], missing, spurious, k)
    return views


def measure(dots: int, path: Path, number: int, cold_number: int, build_seconds: float) -> Measured:
    """Ask for the poses of views of a hall; to be called in a process of its own."""
    use_one_core()
    hall = Hall(dots, 1)
    views = [views_of(hall, number, *condition) for condition in CONDITIONS]
    _answer(path, views[0][0])  # compiles
    cold, reads = [], []
    for view in views[0][:: max(number // cold_number, 1)]:
        _drop_from_page_cache(path)
        before = resource.getrusage(resource.RUSAGE_SELF).ru_majflt
        cold.append(_answer(path, view))
        reads.append(resource.getrusage(resource.RUSAGE_SELF).ru_majflt - before)
    _read_into_page_cache(path)
    begin = time.perf_counter()
    floor = load_indexed_map(path)
    open_milliseconds = 1e3 * (time.perf_counter() - begin)
    locate = constellation_of(floor)
    warm = [
        [
            time_answer(lambda pixels: locate(pixels).T_map_view, view.pixels, view.T_map_view)
            for view in of_one
        ]
        for of_one in views
    ]
    return Measured(
        hall.dots,
        path.stat().st_size,
        build_seconds,
        open_milliseconds,
        _private_bytes(),
        warm,
        cold,
        reads,
    )


def _answer(path: Path, view: PaperView) -> TimedAnswer:
    """Open a map and answer one view, timed by the clock."""
    begin = time.perf_counter()
    locate = constellation_of(load_indexed_map(path))

    def pose(pixels: NDArray[np.float64]) -> SE2 | None:
        return locate(pixels).T_map_view

    verdict = time_answer(pose, view.pixels, view.T_map_view).verdict
    return TimedAnswer(verdict, time.perf_counter() - begin)


def _drop_from_page_cache(path: Path) -> None:
    """Put a file out of the page cache; nobody maps it now."""
    with path.open('rb') as file:
        os.fsync(file.fileno())
        os.posix_fadvise(file.fileno(), 0, 0, os.POSIX_FADV_DONTNEED)


def _read_into_page_cache(path: Path) -> None:
    """Read a file into the page cache."""
    with path.open('rb') as file:
        while file.read(_BLOCK):
            pass


def _private_bytes() -> int:
    lines = Path('/proc/self/status').read_text().splitlines()
    return 1024 * int(next(line for line in lines if line.startswith('RssAnon')).split()[1])


def print_index(halls: list[Measured]) -> None:
    """Print what the maps cost."""
    print(
        '\n| dots | hall | file | bytes a dot | built in s (CPU) | µs a dot | opened in ms | private memory |'
    )
    print('|---|---|---|---|---|---|---|---|')
    for hall in halls:
        area = Hall(hall.dots, 1).side ** 2
        print(
            f'| {hall.dots:,} | {area:.0f} m² | {hall.file_bytes / 1e9:.2f} GB | {hall.file_bytes / hall.dots:.0f} '
            f'| {hall.build_seconds:.0f} | {1e6 * hall.build_seconds / hall.dots:.1f} '
            f'| {hall.open_milliseconds:.1f} | {hall.private_bytes / 1e6:.0f} MB |'
        )


def print_fixes(halls: list[Measured]) -> None:
    """Print the times to a fix."""
    for k, (missing, spurious) in enumerate(CONDITIONS):
        print(f'\n{100 * missing:.0f} % missing, {100 * spurious:.0f} % spurious, file in the page cache:\n')
        print('| dots | time ms: median / 95 % | in units of the first: median | right / none / wrong |')
        print('|---|---|---|---|')
        first = time_quantiles(halls[0].warm[k])[0]
        for hall in halls:
            median, high = time_quantiles(hall.warm[k])
            print(
                f'| {hall.dots:,} | {median:.2f} / {high:.2f} | {median / first:.1f} | {outcome_rates(hall.warm[k])} |'
            )
    print('\nCold, reopened for each view, wall time:\n')
    print('| dots | time ms: median / 95 % / longest | pages read: median | right / none / wrong |')
    print('|---|---|---|---|')
    for hall in halls:
        median, high = time_quantiles(hall.cold)
        longest = 1e3 * max(answer.seconds for answer in hall.cold)
        print(
            f'| {hall.dots:,} | {median:.0f} / {high:.0f} / {longest:.0f} | {np.median(hall.cold_reads):.0f} '
            f'| {outcome_rates(hall.cold)} |'
        )


def main() -> int:
    """Run the benchmark."""
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument('--dots', type=int, nargs='+', default=[91582, 1_000_000, 10_000_000])
    parser.add_argument('--views', type=int, default=200, help='of each condition')
    parser.add_argument('--cold-views', type=int, default=40)
    parser.add_argument('--workers', type=int, default=os.cpu_count() or 1, help='processes that build')
    parser.add_argument('--folder', type=Path, help='keeps maps and unfinished builds there')
    arguments = parser.parse_args()
    with tempfile.TemporaryDirectory() as temporary:
        folder = arguments.folder or Path(temporary)
        folder.mkdir(parents=True, exist_ok=True)
        halls = []
        for dots in arguments.dots:
            path = folder / f'{dots}.dotmap'
            seconds = build(Hall(dots, 1), path, arguments.workers)
            with ProcessPoolExecutor(1, mp_context=get_context('spawn')) as one:
                asked = one.submit(measure, dots, path, arguments.views, arguments.cold_views, seconds)
                halls.append(asked.result())
    print_index(halls)
    print_fixes(halls)
    return 0


if __name__ == '__main__':
    raise SystemExit(main())
