"""Plan of a build (stripes of rows of cells, ranges of buckets) and its tasks, which read and write files only."""

import math
import os
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from floor_localizer.core.arrays import Float32s, Floats, Ints
from floor_localizer.core.constellation.constellation_index import list_constellations, sort_into_buckets
from floor_localizer.core.constellation.dot_grid import (
    BLOCK_ROWS,
    DotGrid,
    GridLayout,
    count_pairs,
    rows_and_columns,
    sort_into_cells,
)
from floor_localizer.core.constellation.index_format import IndexRules, index_rules
from floor_localizer.core.errors import DotMapError
from floor_localizer.files.array_file import PartsFolder
from floor_localizer.files.binary_format import ArrayLocation
from floor_localizer.files.dot_map_file import find_duplicates
from floor_localizer.files.map_building.csv_chunks import CsvChunk, read_chunk

# Rows of the halo around a stripe that its constellations reach into, plus one for rounding at the end points.
MARGIN_ROWS = 4
_BUCKETS_PER_RANGE = 1 << 20


@dataclass(frozen=True)
class BuildPlan:
    """Parameters of the build, shared by all tasks.

    Attributes:
        folder: folder of the parts.
        chunks: number of chunks of the CSV.
        offsets: x and y of the origin of each level in the map [m].
        frame: grid of cells of the floor.
        rules: parameters of the index.
        dots: number of dots.
        with_diameters: whether any diameter is known.
        stripe_rows: rows of cells in a stripe.
    """

    folder: Path
    chunks: int
    offsets: tuple[tuple[float, float], ...]
    frame: GridLayout
    rules: IndexRules
    dots: int
    with_diameters: bool
    stripe_rows: int

    @property
    def stripes(self) -> int:
        """Number of stripes."""
        return math.ceil(self.frame.rows / self.stripe_rows)

    @property
    def ranges(self) -> int:
        """Number of ranges of buckets."""
        return math.ceil(self.rules.buckets / _BUCKETS_PER_RANGE)

    def rows_of(self, stripe: int) -> tuple[int, int]:
        """Return the first row of a stripe and one past the last."""
        begin = stripe * self.stripe_rows
        return begin, min(begin + self.stripe_rows, self.frame.rows)

    def buckets_of(self, number: int) -> tuple[int, int]:
        """Return the first bucket of a range and one past the last."""
        begin = number * _BUCKETS_PER_RANGE
        return begin, min(begin + _BUCKETS_PER_RANGE, self.rules.buckets)


def plan_build(
    folder: Path,
    chunks: int,
    offsets: tuple[tuple[float, float], ...],
    frame: GridLayout,
    dots: int,
    *,
    with_diameters: bool,
    stripe_dots: int,
) -> BuildPlan:
    """Return the plan for a map, with about ``stripe_dots`` dots in a stripe; other arguments as in `BuildPlan`.

    Raises:
        FloorLocalizerError: there are too many dots for one map.
    """
    blocks = math.ceil(frame.rows / max(math.ceil(dots / stripe_dots), 1) / BLOCK_ROWS)
    return BuildPlan(
        folder, chunks, offsets, frame, index_rules(dots, frame.cell), dots, with_diameters, blocks * BLOCK_ROWS
    )


Places = Mapping[str, ArrayLocation]


def read_dots(folder: Path, number: int, chunk: CsvChunk) -> None:
    """Parse a chunk of the CSV; report its number of dots, their bounding box and median diameter."""
    parts = PartsFolder(folder)
    table = read_chunk(chunk)
    known = table[np.isfinite(table[:, 2]), 2]
    parts.save('dots', number, table)
    lower, upper = table[:, :2].min(axis=0, initial=np.inf), table[:, :2].max(axis=0, initial=-np.inf)
    box = {'lower': lower.tolist(), 'upper': upper.tolist()}
    diameter = float(np.median(known)) if len(known) else None
    parts.finish('read', number, {'sheet': chunk.level, 'dots': len(table), **box, 'diameter': diameter})


def points_on_map(table: Floats, offset: tuple[float, float]) -> Float32s:
    """Return the dots of a level, shape (n, >= 2) [m], in the map frame in single precision, shape (n, 2)."""
    return (table[:, :2] + offset).astype(np.float32)


def split_into_stripes(plan: BuildPlan, number: int, level: int) -> None:
    """Sort the dots of a chunk by stripe; report the number in each."""
    parts = PartsFolder(plan.folder)
    table = parts.load('dots', number)
    points = points_on_map(table, plan.offsets[level])
    row, _ = rows_and_columns(plan.frame, points.astype(np.float64))
    stripes = row // plan.stripe_rows
    order = np.argsort(stripes, kind='stable')
    parts.save('cut', number, np.column_stack([points, table[:, 2].astype(np.float32)])[order])
    parts.finish('cut', number, np.bincount(stripes, minlength=plan.stripes).tolist())


def index_stripe(plan: BuildPlan, places: Places, stripe: int, ends: Ints) -> None:
    """Write the dots of a stripe to the map and list its constellations; report the pairs, and entries by range.

    ``places`` are those of the arrays in the map file; ``ends``, shape (chunks, stripes + 1), are the first dot of each
    stripe in each chunk, then the number of dots.
    """
    parts, frame = PartsFolder(plan.folder), plan.frame
    rows = plan.rows_of(stripe)
    table, before = _dots_around(plan, parts, stripe, ends)
    low, high = max(rows[0] - MARGIN_ROWS, 0), min(rows[1] + MARGIN_ROWS, frame.rows)
    row, column = rows_and_columns(frame, table[:, :2].astype(np.float64))
    order, starts = sort_into_cells((row - low) * frame.columns + column, (high - low) * frame.columns)
    points = np.ascontiguousarray(table[order, :2])
    begin, end = (int(starts[(r - low) * frame.columns]) for r in rows)
    _reject_duplicates(points[begin:end].astype(np.float64), frame.x0, frame.y0)
    own = starts[(rows[0] - low) * frame.columns : (rows[1] - low) * frame.columns + 1].astype(np.int64)
    _write(parts.map_file, places['grid.points'], 2 * before, points[begin:end])
    _write(parts.map_file, places['grid.starts'], rows[0] * frame.columns, own - begin + before)
    if plan.with_diameters:
        _write(parts.map_file, places['diameters'], before, table[order[begin:end], 2])
    for array in (points, starts):
        array.flags.writeable = False
    y0 = frame.y0 + low * frame.cell
    grid = DotGrid(points, starts, frame.x0, y0, frame.cell, frame.columns, high - low)
    buckets, entries = list_constellations(grid, begin, end, before - begin, plan.rules)
    ranges = (buckets // np.uint32(_BUCKETS_PER_RANGE)).astype(np.uint16)
    by_range = np.argsort(ranges, kind='stable')
    parts.save('buckets', stripe, buckets[by_range])
    parts.save('entries', stripe, entries[by_range])
    pairs = count_pairs(np.diff(own).reshape(rows[1] - rows[0], frame.columns))
    parts.finish('index', stripe, {'pairs': pairs, 'entries': np.bincount(ranges, minlength=plan.ranges).tolist()})


def _dots_around(plan: BuildPlan, parts: PartsFolder, stripe: int, ends: Ints) -> tuple[Float32s, int]:
    """Return the dots of a stripe and its halo, shape (n, 3), and the number of dots before the stripe."""
    first, last = max(stripe - 1, 0), min(stripe + 1, plan.stripes - 1)
    low, high = plan.rows_of(stripe)
    tables = []
    for chunk, cut in enumerate(parts.load_all('cut', plan.chunks)):
        table = np.asarray(cut[ends[chunk, first] : ends[chunk, last + 1]])
        row, _ = rows_and_columns(plan.frame, table[:, :2].astype(np.float64))
        tables.append(table[(row >= low - MARGIN_ROWS) & (row < high + MARGIN_ROWS)])
    return np.concatenate(tables), int(np.sum(ends[:, stripe] - ends[:, 0]))


def _reject_duplicates(points: Floats, x0: float, y0: float) -> None:
    duplicates = find_duplicates(points, np.array([x0, y0])) if len(points) else None
    if duplicates is not None:
        x, y = points[duplicates[0]]
        raise DotMapError(f'the dot at ({x:.6f}, {y:.6f}) m is in the map twice; remove one of them')


def sort_range(plan: BuildPlan, places: Places, number: int, slices: Ints, entries_before: int) -> None:
    """Write the entries of a range of buckets and the first entry of each bucket to the map.

    ``slices``, shape (stripes, 2), are the first entry and one past the last of the range in each stripe;
    ``entries_before`` is the number of entries of the previous ranges.
    """
    parts = PartsFolder(plan.folder)
    begin, end = plan.buckets_of(number)
    gathered: dict[str, Any] = {
        name: np.concatenate(
            [array[a:b] for array, (a, b) in zip(parts.load_all(name, plan.stripes), slices, strict=True)]
        )
        for name in ('buckets', 'entries')
    }
    starts = np.zeros(end - begin + 1, dtype=np.uint32)
    entries = sort_into_buckets(gathered['buckets'], gathered['entries'], begin, starts)
    _write(parts.map_file, places['index.entries'], entries_before, entries)
    _write(parts.map_file, places['index.starts'], begin, starts.astype(np.int64) + entries_before)
    parts.finish('sort', number, len(entries))


def _write(path: Path, place: ArrayLocation, first: int, values: NDArray[Any]) -> None:
    """Write values to an array of the map, starting at element ``first``."""
    content = np.ascontiguousarray(values, place.dtype).tobytes()
    with path.open('r+b') as file:
        file.seek(place.offset + first * np.dtype(place.dtype).itemsize)
        file.write(content)
        file.flush()
        os.fdatasync(file.fileno())
