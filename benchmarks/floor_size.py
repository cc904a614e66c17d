"""The same views on floors of 1, 10 and 100 times the paper's area: time to a fix without a prior, and the index.

    shirube bench floor_size
    shirube bench floor_size --times 1 10 --places 100

The larger floors hold the paper's floor in a corner, so that the views are the same; the floors take turns after every
twenty views. Times are processor time on one core. 100 times the area takes 8 GB of memory and some minutes.
"""

from __future__ import annotations

import argparse
import tempfile
import time
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from _large_floors import large_floor
from _paper_matchers import constellation_of
from _paper_views import FLOOR_DOTS, PaperView, paper_floor, paper_places, paper_views
from _timed_answers import TimedAnswer, outcome_rates, time_answer, time_quantiles, use_one_core
from numpy.typing import NDArray
from tqdm import tqdm

from floor_localizer.core.compile_kernels import compile_kernels
from floor_localizer.core.constellation.indexed_map import IndexedMap, index_map
from floor_localizer.core.dots import DotMap
from floor_localizer.files.binary_format import BinaryMap, load_binary, save_binary
from shirube_core.geometry import SE2

CONDITIONS = ((0.25, 0.3), (0.25, 0.5))
TURN = 20

Locate = Callable[[NDArray[np.float64]], SE2 | None]


@dataclass(frozen=True)
class Floor:
    """One floor, ready.

    Attributes:
        times: its area in the paper's floors.
        build_seconds: processor time to index it.
        bytes_in_memory: size of all arrays of the indexed map.
        bytes_in_file: size of the ``.dotmap`` file.
        open_seconds: time to open that.
        in_memory: locates a view on the map in memory.
        from_file: locates it on the memory-mapped map.
    """

    times: int
    build_seconds: float
    bytes_in_memory: int
    bytes_in_file: int
    open_seconds: float
    in_memory: Locate
    from_file: Locate


def build_floor(times: int, seed: int, folder: Path) -> Floor:
    """Index a floor and write it to a file."""
    dots = large_floor(times, seed)
    unknown = np.full(len(dots), np.nan)
    begin = time.process_time()
    floor = index_map(DotMap(dots, unknown))
    build_seconds = time.process_time() - begin
    path = folder / f'{times}.dotmap'
    save_binary(path, BinaryMap(floor, unknown.astype(np.float32)))
    begin = time.perf_counter()
    mapped = load_binary(path).floor
    open_seconds = time.perf_counter() - begin
    return Floor(
        times,
        build_seconds,
        _bytes_of(floor),
        path.stat().st_size,
        open_seconds,
        _locate(floor),
        _locate(mapped),
    )


def _bytes_of(floor: IndexedMap) -> int:
    parts = [*floor.grid, *floor.index, *floor.addresses]
    return sum(part.nbytes for part in parts if isinstance(part, np.ndarray))


def _locate(floor: IndexedMap) -> Locate:
    matcher = constellation_of(floor)
    return lambda pixels: matcher(pixels).T_map_view


def print_index(floors: list[Floor]) -> None:
    """Print what the index costs."""
    print('\n| area | dots | index built in s | bytes a dot in memory | in the file | file opened in ms |')
    print('|---|---|---|---|---|---|')
    for floor in floors:
        dots = floor.times * FLOOR_DOTS
        print(
            f'| {floor.times}x | {dots:,} | {floor.build_seconds:.2f} | {floor.bytes_in_memory / dots:.0f} '
            f'| {floor.bytes_in_file / dots:.0f} | {1e3 * floor.open_seconds:.1f} |'
        )


def print_times(floors: list[Floor], answers: dict[tuple[int, str], list[TimedAnswer]]) -> None:
    """Print one condition."""
    print(
        '| area | map | time ms: median / 95 % | in units of the first: median / 95 % | right / none / wrong |'
    )
    print('|---|---|---|---|---|')
    for where in ('in memory', 'from the file'):
        first = time_quantiles(answers[floors[0].times, where])
        for floor in floors:
            median, high = time_quantiles(answers[floor.times, where])
            print(
                f'| {floor.times}x | {where} | {median:.2f} / {high:.2f} '
                f'| {median / first[0]:.2f} / {high / first[1]:.2f} | {outcome_rates(answers[floor.times, where])} |'
            )


def measure(floors: list[Floor], views: list[PaperView]) -> dict[tuple[int, str], list[TimedAnswer]]:
    """Locate the views on all floors by turns."""
    places = [(floor.times, 'in memory', floor.in_memory) for floor in floors]
    places += [(floor.times, 'from the file', floor.from_file) for floor in floors]
    answers: dict[tuple[int, str], list[TimedAnswer]] = {(times, where): [] for times, where, _ in places}
    for begin in tqdm(range(0, len(views), TURN), leave=False):
        for times, where, locate in places:
            for view in views[begin : begin + TURN]:
                answers[times, where].append(time_answer(locate, view.pixels, view.T_map_view))
    return answers


def main() -> int:
    """Run the benchmark."""
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument('--times', type=int, nargs='+', default=[1, 10, 100], help='areas in paper floors')
    parser.add_argument('--places', type=int, default=1209, help='views of each condition')
    parser.add_argument('--seed', type=int, default=1)
    arguments = parser.parse_args()
    use_one_core()
    compile_kernels()
    places = paper_places()
    places = places[np.linspace(0, len(places) - 1, min(arguments.places, len(places))).round().astype(int)]
    with tempfile.TemporaryDirectory() as folder:
        sizes = tqdm(arguments.times, unit='floor', leave=False)
        floors = [build_floor(times, arguments.seed, Path(folder)) for times in sizes]
        print_index(floors)
        paper = paper_floor(arguments.seed)
        for missing, spurious in CONDITIONS:
            views = list(paper_views(paper, places, missing, spurious, arguments.seed))
            print(f'\n{100 * missing:.0f} % missing, {100 * spurious:.0f} % spurious, {len(views)} views:\n')
            print_times(floors, measure(floors, views))
    return 0


if __name__ == '__main__':
    raise SystemExit(main())
