"""Halls of up to 10^8 dots: what their index costs, and the time to a fix without a prior.

    shirube bench floor_size
    shirube bench floor_size --dots 100000000 --folder /data/hall --workers 2

Each hall is written as CSV, indexed by ``index_map`` and asked in a process of its own, with the file in the page
cache. Times to build and to a fix are processor time, in units of the first hall's as well; opening is by the clock.
10^8 dots take 25 GB of disk while they are indexed, and an hour; a map that is there is used again.
"""

import math
import subprocess
import sys
import tempfile
from concurrent.futures import ProcessPoolExecutor
from multiprocessing import get_context
from pathlib import Path
from time import perf_counter
from typing import NamedTuple

import numpy as np
from _figures import count, measured
from _harness import Option, Run, children_cpu_seconds, run_benchmark, use_one_core
from _paper_matchers import constellation
from _paper_views import CONDITIONS, VIEW_SIZE, PaperView, paper_views
from _pose_scores import PoseScore, time_answer, time_cells
from numpy.typing import NDArray

from floor_localizer.files.dot_map_file import HEADER, load_indexed_map

DENSITY = 5384.0
STEP = 2e-5
_BLOCK = 1 << 24


class Hall(NamedTuple):
    """A square hall of evenly random dots, shape (n, 2) [m], and its side [m]."""

    dots: NDArray[np.float64]
    side: float

    def views(self, number: int, missing: float, spurious: float) -> list[PaperView]:
        """Return views all over it."""
        views: list[PaperView] = []
        places = np.random.default_rng(number).uniform(VIEW_SIZE, self.side - VIEW_SIZE, (number, 2))
        for k, place in enumerate(places):
            near = self.dots[(np.abs(self.dots - place) < VIEW_SIZE).all(axis=1)]
            views += paper_views(near, place[None, :], missing, spurious, k)
        return views


def hall_of(dots: int) -> Hall:
    """Return a hall of about so many dots; they lie on a lattice, no two on the same place."""
    side = math.sqrt(dots / DENSITY)
    columns = int(side / STEP)
    places = np.unique(np.random.default_rng([1, dots]).integers(0, columns**2, dots))
    np.random.default_rng(2).shuffle(places)
    return Hall(np.column_stack(np.divmod(places, columns)) * STEP, side)


class Measured(NamedTuple):
    """Time to open a map [ms], private memory of the process [bytes], and answers for each condition."""

    open_milliseconds: float
    private_bytes: int
    warm: list[list[PoseScore]]


def build(hall: Hall, path: Path, workers: int) -> float:
    """Write a hall and index it; return the processor time of the index [s], NaN where the map was there."""
    if path.exists():
        return math.nan
    source = path.with_suffix('.csv')
    if not source.exists():
        written = source.with_suffix('.written')
        np.savetxt(written, hall.dots, '%.5f,%.5f,', header=HEADER, comments='')
        written.replace(source)
    before = children_cpu_seconds()
    command = [sys.executable, '-m', 'floor_localizer.commands.index_map', str(source), '--out', str(path)]
    subprocess.run([*command, '--workers', str(workers)], check=True, stdout=subprocess.DEVNULL)
    source.unlink()
    return children_cpu_seconds() - before


def measure(dots: int, path: Path, number: int) -> Measured:
    """Ask for the poses of views of a hall; to be called in a process of its own."""
    use_one_core()
    views = [hall_of(dots).views(number, *condition) for condition in CONDITIONS.values()]
    with path.open('rb') as file:
        while file.read(_BLOCK):
            pass
    begin = perf_counter()
    floor = load_indexed_map(path)
    open_milliseconds = 1e3 * (perf_counter() - begin)
    locate = constellation(floor)
    warm = [
        [time_answer(lambda pixels: locate(pixels).T_map_view, view.pixels, view.T_map_view) for view in each]
        for each in views
    ]
    lines = Path('/proc/self/status').read_text().splitlines()
    private = 1024 * int(next(line for line in lines if line.startswith('RssAnon')).split()[1])
    return Measured(open_milliseconds, private, warm)


def add_fixes(run: Run, halls: dict[int, Measured]) -> None:
    """Add the times to a fix."""
    first = next(iter(halls.values()))
    for k, name in enumerate(CONDITIONS):
        heads = 'dots | time ms: median / 95 % | median in units of the first | right / none / wrong'
        table = run.table(f'{name}, file in the page cache', heads)
        for dots, hall in halls.items():
            table.add(f'{dots:,}', *time_cells(hall.warm[k], first.warm[k]))


def main(run: Run, dots: tuple[int, ...], views: int, workers: int, folder: str) -> None:
    """Build the halls and ask them."""
    heads = 'dots | hall m² | file GB | bytes a dot | built in s (CPU) | opened in ms | private memory MB'
    table, halls = run.table('Maps', heads), {}
    with tempfile.TemporaryDirectory() as temporary:
        place = Path(folder or temporary)
        place.mkdir(parents=True, exist_ok=True)
        for wanted in dots:
            path, hall = place / f'{wanted}.dotmap', hall_of(wanted)
            seconds = build(hall, path, workers)
            with ProcessPoolExecutor(1, mp_context=get_context('spawn')) as one:
                found = one.submit(measure, wanted, path, views).result()
            size = path.stat().st_size
            halls[len(hall.dots)] = found
            table.add(
                *(f'{len(hall.dots):,}', f'{hall.side**2:.0f}', f'{size / 1e9:.2f}'),
                *(count(size / len(hall.dots), '.0f', better='lower'), measured(seconds, '.0f')),
                *(measured(found.open_milliseconds, '.1f'), measured(found.private_bytes / 1e6, '.0f')),
            )
    add_fixes(run, halls)


if __name__ == '__main__':
    run_benchmark(
        main,
        dots=Option((91582, 1_000_000, 10_000_000), (91582,), 'of the halls'),
        views=Option(200, 40, 'of each condition'),
        workers=Option(2, 2, 'processes that build'),
        folder=Option('', '', 'keeps maps and unfinished builds there'),
    )
