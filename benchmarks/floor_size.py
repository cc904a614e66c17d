"""Halls of up to 10^8 dots: what their index costs, and the time to a fix without a prior, warm and cold.

    shirube bench floor_size
    shirube bench floor_size --dots 100000000 --folder /data/hall --workers 2

Each hall is written as CSV, indexed by ``index_map`` and asked in a process of its own. Times to build and to a fix are
processor time, in units of the first hall's as well; opening and cold fixes are by the clock: for these the file is
put out of the page cache before each view. 10^8 dots take 25 GB of disk while they are indexed, and an hour; a build
that was stopped goes on, and a map that is there is used again.
"""

from __future__ import annotations

import math
import os
import resource
import subprocess
import sys
import tempfile
import time as clock
from concurrent.futures import ProcessPoolExecutor
from dataclasses import dataclass
from multiprocessing import get_context
from pathlib import Path

import numpy as np
from _figures import count, measured, outcomes, ratio, time
from _harness import Option, Run, run_benchmark, use_one_core
from _paper_matchers import constellation_of
from _paper_views import VIEW_SIZE, PaperView, paper_views
from _pose_scores import TimedAnswer, time_answer, verdict_of
from numpy.typing import NDArray

from floor_localizer.files.csv_format import HEADER
from floor_localizer.files.dot_map_file import load_indexed_map

CONDITIONS = ((0.25, 0.3), (0.25, 0.5))
DENSITY = 5384.0
# Dots lie on a lattice, no two on the same place [m].
_STEP = 2e-5
_STRIP_DOTS = 500_000
_STRIPS_PER_ROW = 10
_BLOCK = 1 << 24


class Hall:
    """A square hall of evenly random dots, strip by strip: never are all of them held."""

    def __init__(self, dots: int, seed: int) -> None:
        self._seed = seed
        self._strips = max(round(dots / _STRIP_DOTS), 1)
        self._per_strip = dots // self._strips
        self.dots = self._per_strip * self._strips
        self.side = math.sqrt(dots / DENSITY)
        self._columns = int(self.side / _STEP)
        self._rows = int(self.side / self._strips / _STEP)
        self._kept: dict[int, NDArray[np.int64]] = {}

    def strip(self, number: int) -> NDArray[np.int64]:
        """Return the dots of one strip on the lattice, shape (n, 2), in random order."""
        rng = np.random.default_rng([self._seed, self._strips, number])
        places = np.empty(0, dtype=np.int64)
        while len(places) < self._per_strip:
            more = rng.integers(0, self._columns * self._rows, self._per_strip - len(places))
            places = np.unique(np.concatenate([places, more]))
        row, column = np.divmod(rng.permutation(places), self._columns)
        return np.column_stack([column, row + number * self._rows])

    def around(self, place: NDArray[np.float64], reach: float) -> NDArray[np.float64]:
        """Return the dots in a square of half this width around a place, shape (n, 2) [m]."""
        height = self._rows * _STEP
        first = max(int((place[1] - reach) / height), 0)
        last = min(int((place[1] + reach) / height), self._strips - 1)
        for number in range(first, last + 1):
            if number not in self._kept:
                self._kept = {k: strip for k, strip in self._kept.items() if k >= first}
                self._kept[number] = self.strip(number)
        dots = np.vstack([self._kept[number] for number in range(first, last + 1)]) * _STEP
        return np.asarray(dots[(np.abs(dots - place) < reach).all(axis=1)])

    def places(self, number: int, margin: float) -> NDArray[np.float64]:
        """Return places all over the hall but near its walls, ten side by side, shape (number, 2) [m]."""
        rng = np.random.default_rng([self._seed, number])
        low, high = margin, self.side - margin
        rows = np.linspace(low, high, -(-number // _STRIPS_PER_ROW)).repeat(_STRIPS_PER_ROW)[:number]
        return np.column_stack([rng.uniform(low, high, number), rows])

    def write(self, path: Path) -> None:
        """Write it as CSV."""
        with path.open('w') as file:
            file.write(f'{HEADER}\n')
            for number in range(self._strips):
                np.savetxt(file, self.strip(number) * _STEP, '%.5f,%.5f,')

    def views(self, number: int, missing: float, spurious: float) -> list[PaperView]:
        """Return views all over it."""
        views: list[PaperView] = []
        for k, place in enumerate(self.places(number, VIEW_SIZE)):
            views += paper_views(self.around(place, VIEW_SIZE), place[None, :], missing, spurious, k)
        return views


@dataclass(frozen=True)
class Measured:
    """What one hall came to.

    Attributes:
        open_milliseconds: time to open the map.
        private_bytes: memory of the process that answered, without what it maps of files.
        warm: answers with the file in the page cache, for each condition.
        cold: answers without, under the first condition.
        cold_reads: pages read from the disk for each of these.
    """

    open_milliseconds: float
    private_bytes: int
    warm: list[list[TimedAnswer]]
    cold: list[TimedAnswer]
    cold_reads: list[int]


def build(hall: Hall, path: Path, workers: int) -> float:
    """Write a hall and index it; return the processor time of the index [s], NaN where the map was there."""
    if path.exists():
        return math.nan
    source = path.with_suffix('.csv')
    if not source.exists():
        written = source.with_suffix('.written')
        hall.write(written)
        written.replace(source)
    before = resource.getrusage(resource.RUSAGE_CHILDREN)
    command = [sys.executable, '-m', 'floor_localizer.commands.index_map', str(source), '--out', str(path)]
    subprocess.run([*command, '--workers', str(workers)], check=True, stdout=subprocess.DEVNULL)
    after = resource.getrusage(resource.RUSAGE_CHILDREN)
    source.unlink()
    return after.ru_utime - before.ru_utime + after.ru_stime - before.ru_stime


def measure(dots: int, path: Path, number: int, cold_number: int) -> Measured:
    """Ask for the poses of views of a hall; to be called in a process of its own."""
    use_one_core()
    views = [Hall(dots, 1).views(number, *condition) for condition in CONDITIONS]
    _cold_answer(path, views[0][0])  # compiles
    cold, reads = [], []
    for view in views[0][:: max(number // cold_number, 1)]:
        with path.open('rb') as file:  # nobody maps it now
            os.fsync(file.fileno())
            os.posix_fadvise(file.fileno(), 0, 0, os.POSIX_FADV_DONTNEED)
        before = resource.getrusage(resource.RUSAGE_SELF).ru_majflt
        cold.append(_cold_answer(path, view))
        reads.append(resource.getrusage(resource.RUSAGE_SELF).ru_majflt - before)
    with path.open('rb') as file:
        while file.read(_BLOCK):
            pass
    begin = clock.perf_counter()
    floor = load_indexed_map(path)
    open_milliseconds = 1e3 * (clock.perf_counter() - begin)
    locate = constellation_of(floor)
    warm = [
        [time_answer(lambda pixels: locate(pixels).T_map_view, view.pixels, view.T_map_view) for view in each]
        for each in views
    ]
    lines = Path('/proc/self/status').read_text().splitlines()
    private = 1024 * int(next(line for line in lines if line.startswith('RssAnon')).split()[1])
    return Measured(open_milliseconds, private, warm, cold, reads)


def _cold_answer(path: Path, view: PaperView) -> TimedAnswer:
    """Open a map and answer one view, timed by the clock."""
    begin = clock.perf_counter()
    found = constellation_of(load_indexed_map(path))(view.pixels).T_map_view
    return TimedAnswer(verdict_of(found, view.T_map_view), 1e3 * (clock.perf_counter() - begin))


def add_fixes(run: Run, halls: dict[int, Measured]) -> None:
    """Add the times to a fix."""
    first = next(iter(halls.values()))
    heads = 'dots', 'time ms: median / 95 %', 'median in units of the first', 'right / none / wrong'
    for k, (missing, spurious) in enumerate(CONDITIONS):
        name = f'{100 * missing:.0f} % missing, {100 * spurious:.0f} % spurious, file in the page cache'
        table = run.table(name, *heads)
        base = [answer.milliseconds for answer in first.warm[k]]
        for dots, hall in halls.items():
            times = [answer.milliseconds for answer in hall.warm[k]]
            table.add(f'{dots:,}', time(times), ratio(times, base), outcomes(a.verdict for a in hall.warm[k]))
    table = run.table(
        'Cold, by the clock', 'dots', 'time ms: median / 95 % / max', 'pages read', 'right / none / wrong'
    )
    for dots, hall in halls.items():
        times = [answer.milliseconds for answer in hall.cold]
        pages = measured(float(np.median(hall.cold_reads)), '.0f')
        table.add(
            f'{dots:,}', time(times, '.0f', (50, 95, 100)), pages, outcomes(a.verdict for a in hall.cold)
        )


def main(run: Run, dots: tuple[int, ...], views: int, cold_views: int, workers: int, folder: str) -> None:
    """Build the halls and ask them."""
    heads = 'hall m²', 'file GB', 'bytes a dot', 'built in s (CPU)', 'opened in ms', 'private memory MB'
    table, halls = run.table('Maps', 'dots', *heads), {}
    with tempfile.TemporaryDirectory() as temporary:
        place = Path(folder or temporary)
        place.mkdir(parents=True, exist_ok=True)
        for wanted in dots:
            path, hall = place / f'{wanted}.dotmap', Hall(wanted, 1)
            seconds = build(hall, path, workers)
            with ProcessPoolExecutor(1, mp_context=get_context('spawn')) as one:
                found = one.submit(measure, wanted, path, views, cold_views).result()
            size = path.stat().st_size
            halls[hall.dots] = found
            table.add(
                *(f'{hall.dots:,}', f'{hall.side**2:.0f}', f'{size / 1e9:.2f}'),
                *(count(size / hall.dots, '.0f', better='lower'), measured(seconds, '.0f')),
                *(measured(found.open_milliseconds, '.1f'), measured(found.private_bytes / 1e6, '.0f')),
            )
    add_fixes(run, halls)


if __name__ == '__main__':
    run_benchmark(
        main,
        dots=Option((91582, 1_000_000, 10_000_000), (91582,), 'of the halls'),
        views=Option(200, 40, 'of each condition'),
        cold_views=Option(40, 4, 'of them with the file out of the page cache'),
        workers=Option(2, 2, 'processes that build'),
        folder=Option('', '', 'keeps maps and unfinished builds there'),
    )
