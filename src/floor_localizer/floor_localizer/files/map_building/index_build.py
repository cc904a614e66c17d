"""Build the binary form of a map from CSVs larger than memory, in resumable steps."""

import math
import os
from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
from tqdm import tqdm

from floor_localizer.core.arrays import Floats, Ints
from floor_localizer.core.constellation.constellation_index import ConstellationIndex
from floor_localizer.core.constellation.dot_grid import (
    DotGrid,
    density_from_pairs,
    grid_layout,
    spacing_from_counts,
    square_indices,
)
from floor_localizer.core.constellation.index_format import LARGE_MAP
from floor_localizer.core.constellation.indexed_map import IndexedMap, bitmap_shape, build_map_occupancy
from floor_localizer.core.dots import Level, arrange_levels
from floor_localizer.core.independent_tasks import Task, TaskRunner
from floor_localizer.files import binary_format
from floor_localizer.files.array_file import PartsFolder
from floor_localizer.files.dot_map_file import check_dot_count, check_units
from floor_localizer.files.map_building.build_tasks import (
    BuildPlan,
    index_stripe,
    plan_build,
    points_on_map,
    read_dots,
    sort_range,
    split_into_stripes,
)
from floor_localizer.files.map_building.csv_chunks import file_digest, split_csv

# Largest number of squares for a dense occupancy array.
_SQUARES_MAX = 1 << 28


@dataclass(frozen=True)
class PartSizes:
    """Size of a CSV chunk [bytes] and number of dots in a stripe; they affect memory and time, not the result."""

    chunk_bytes: int = 1 << 25
    stripe_dots: int = 1_000_000


DEFAULT_SIZES = PartSizes()  # a task takes some hundred megabytes and half a minute


class IndexBuild:
    """A build; ``run`` starts or resumes it."""

    def __init__(self, sources: Sequence[Path], out: Path, runner: TaskRunner, sizes: PartSizes | None = None) -> None:
        """Prepare a build.

        Args:
            sources: dot maps as CSV; several are the levels of one map, named after the files.
            out: file to write.
            runner: runs the tasks.
            sizes: sizes of the parts, None for the defaults.
        """
        self._sources = sources
        self._out = out
        self._runner = runner
        self._sizes = sizes or DEFAULT_SIZES
        # Absolute: the tasks may run in another folder.
        self._folder = out.absolute().with_name(f'{out.name}.parts')
        self._parts = PartsFolder(self._folder)

    def run(self) -> None:
        """Build the map, or its missing parts.

        Raises:
            FloorLocalizerError: malformed CSV, parts of another map, or too many dots.
            OSError: the folder cannot be written to, or the disk is full; finished parts are kept.
        """
        chunks = [
            chunk
            for level, source in enumerate(self._sources)
            for chunk in split_csv(source.absolute(), level, self._sizes.chunk_bytes)
        ]
        digests = [[source.name, file_digest(source)] for source in self._sources]
        sizes = [self._sizes.chunk_bytes, self._sizes.stripe_dots]
        self._parts.begin({'version': binary_format.VERSION, 'sources': digests, 'sizes': sizes})
        results = self._run_stage(
            'read', read_dots, [(self._folder, number, chunk) for number, chunk in enumerate(chunks)]
        )
        check_dot_count(sum(chunk['dots'] for chunk in results), ', '.join(map(str, self._sources)))
        levels = self._levels(results)
        plan = self._plan(results, levels)
        counts = self._run_stage(
            'cut', split_into_stripes, [(plan, number, chunk.level) for number, chunk in enumerate(chunks)]
        )
        self._parts.remove_arrays('dots')
        self._write_map(plan, np.array(counts, dtype=np.int64).reshape(len(chunks), -1), levels)
        self._parts.map_file.replace(self._out)
        self._parts.remove()

    def _run_stage(self, stage: str, function: Task, tasks: Sequence[tuple[Any, ...]]) -> list[Any]:
        """Run the unfinished tasks of a stage; return the results of all its tasks."""
        missing = [task for number, task in enumerate(tasks) if self._parts.load_result(stage, number) is None]
        with tqdm(total=len(tasks), initial=len(tasks) - len(missing), desc=stage, disable=None) as bar:
            for _ in self._runner.run(function, missing):
                bar.update()
        return [self._parts.load_result(stage, number) for number in range(len(tasks))]

    def _levels(self, results: Sequence[Any]) -> tuple[Level, ...]:
        """Return the levels, none for a single source."""
        if len(self._sources) == 1:
            return ()
        corners = list[tuple[float, float, float, float]]()
        for number, source in enumerate(self._sources):
            chunks = [chunk for chunk in results if chunk['sheet'] == number]
            check_dot_count(sum(chunk['dots'] for chunk in chunks), str(source))
            x0, y0 = np.min([chunk['lower'] for chunk in chunks], axis=0).tolist()
            x1, y1 = np.max([chunk['upper'] for chunk in chunks], axis=0).tolist()
            corners.append((x0, y0, x1, y1))
        return arrange_levels([source.stem for source in self._sources], corners)

    def _plan(self, results: Sequence[Any], levels: Sequence[Level]) -> BuildPlan:
        """Return the plan of the build, from statistics over all dots."""
        offsets = tuple(level.offset for level in levels) or ((0.0, 0.0),)
        known = self._parts.load_result('spacing', 0)
        if known is None:
            known = self._measure_spacing(results, offsets)
            self._parts.finish('spacing', 0, known)
        dots = sum(chunk['dots'] for chunk in results)
        diameters = [chunk['diameter'] for chunk in results if chunk['diameter'] is not None]
        check_units(
            float(np.median(diameters)) if diameters else 0.0, known['spacing'], ', '.join(map(str, self._sources))
        )
        return plan_build(
            self._folder,
            len(results),
            offsets,
            grid_layout(np.array(known['lower']), np.array(known['upper']), dots, known['spacing']),
            dots,
            with_diameters=bool(diameters),
            stripe_dots=self._sizes.stripe_dots,
        )

    def _measure_spacing(self, results: Sequence[Any], offsets: Sequence[tuple[float, float]]) -> dict[str, Any]:
        """Return the bounding box of the map and the spacing of its dots."""

        def all_points() -> Iterable[Floats]:
            for number, chunk in enumerate(results):
                table = self._parts.load('dots', number)
                yield points_on_map(table, offsets[chunk['sheet']]).astype(np.float64)

        corners = np.array([(p.min(axis=0), p.max(axis=0)) for p in all_points() if len(p)])
        lower, upper = corners[:, 0].min(axis=0), corners[:, 1].max(axis=0)
        dots = sum(chunk['dots'] for chunk in results)

        def occupied(side: float) -> int:
            return _count_occupied((square_indices(p, lower, upper, side) for p in all_points()), lower, upper, side)

        spacing = spacing_from_counts(lower, upper, dots, occupied)
        return {'lower': lower.tolist(), 'upper': upper.tolist(), 'spacing': spacing}

    def _write_map(self, plan: BuildPlan, counts: Ints, levels: Sequence[Level]) -> None:
        """Write dots, index and header to the file in the folder of the parts."""
        ends = np.hstack([np.zeros((len(counts), 1), dtype=np.int64), np.cumsum(counts, axis=1)])
        shapes = _shapes_of(plan)
        places = binary_format.array_locations(shapes)
        self._parts.map_file.touch()
        stripes = [(plan, places, stripe, ends) for stripe in range(plan.stripes)]
        results = self._run_stage('index', index_stripe, stripes)
        self._parts.remove_arrays('cut')
        by_range = np.array([stripe['entries'] for stripe in results], dtype=np.int64)
        shapes['index.entries'] = (int(by_range.sum()),)
        places = binary_format.array_locations(shapes)
        before = np.concatenate([[0], np.cumsum(by_range.sum(axis=0))])
        stops = np.cumsum(by_range, axis=1)
        slices = np.stack([stops - by_range, stops], axis=-1)
        tasks = [(plan, places, number, slices[:, number], int(before[number])) for number in range(plan.ranges)]
        self._run_stage('sort', sort_range, tasks)
        density = density_from_pairs(sum(stripe['pairs'] for stripe in results), plan.dots, plan.frame.cell)
        self._write_header(plan, places, density, levels)

    def _write_header(
        self, plan: BuildPlan, places: dict[str, binary_format.ArrayLocation], density: float, levels: Sequence[Level]
    ) -> None:
        """Write the parts that depend on the whole map: address matrix and header."""
        path = self._parts.map_file
        with path.open('r+b') as file:
            file.truncate(binary_format.file_size(places))
        content = np.asarray(np.memmap(path, dtype=np.uint8, mode='r'))
        arrays = {name: binary_format.view_array(content, place) for name, place in places.items()}
        grid = DotGrid(arrays['grid.points'], arrays['grid.starts'], *plan.frame)
        addresses = build_map_occupancy(grid)
        index = ConstellationIndex(arrays['index.entries'], arrays['index.starts'], plan.rules.step, plan.rules.longest)
        floor = IndexedMap(grid, index, addresses, density, tuple(levels))
        binary_map = binary_format.BinaryMap(floor, arrays['diameters'])
        with path.open('r+b') as file:
            file.write(binary_format.header_bytes(self._out, places, binary_map))
            file.seek(places['addresses.bits'].offset)
            file.write(addresses.bits.tobytes())
            file.flush()
            os.fsync(file.fileno())


def _shapes_of(plan: BuildPlan) -> dict[str, tuple[int, ...]]:
    """Return the shapes of the map's arrays, with no entries yet."""
    frame, dots = plan.frame, plan.dots
    return {
        'diameters': (dots if plan.with_diameters else 0,),
        'grid.points': (dots, 2),
        'grid.starts': (frame.rows * frame.columns + 1,),
        'addresses.bits': (0, 0) if dots > LARGE_MAP else bitmap_shape(frame.rows, frame.columns),
        'index.starts': (plan.rules.buckets + 1,),
        'index.entries': (0,),
    }


def _count_occupied(parts: Iterable[Ints], lower: Floats, upper: Floats, side: float) -> int:
    """Return the number of distinct squares in all parts."""
    squares = math.prod(int(length // side) + 1 for length in np.maximum(upper - lower, 1e-3))
    if squares <= _SQUARES_MAX:
        is_occupied = np.zeros(squares, dtype=np.bool_)
        for part in parts:
            is_occupied[part] = True
        return int(np.count_nonzero(is_occupied))
    distinct = np.empty(0, dtype=np.int64)
    for part in parts:
        distinct = np.union1d(distinct, part)
    return len(distinct)
