"""Loads time intervals from a CSV file, for example those in which the floor was covered by dirt."""

from __future__ import annotations

import csv
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from shirube_bags.errors import TrajectoryError
from shirube_bags.stamps import stamp_from_text


def load_intervals(path: Path | str) -> NDArray[np.int64]:
    """Load a CSV file with the columns ``start`` and ``end`` [s]; other columns are ignored.

    Returns:
        array of int64, shape (n, 2) [ns]; n may be 0.

    Raises:
        TrajectoryError: the file is missing, has no such columns, or a line is malformed.
    """
    intervals = []
    try:
        with Path(path).open(encoding='utf-8', newline='') as file:
            rows = csv.DictReader(file)
            if not {'start', 'end'} <= set(rows.fieldnames or ()):
                raise TrajectoryError(f'{path}: has no columns start and end; write the header "start,end"')
            for row in rows:
                try:
                    start, end = stamp_from_text(row['start'] or ''), stamp_from_text(row['end'] or '')
                except ValueError as fault:
                    raise TrajectoryError(f'{path}, line {rows.line_num}: {fault}; write seconds') from fault
                if end < start:
                    raise TrajectoryError(
                        f'{path}, line {rows.line_num}: ends before it starts; swap the two'
                    )
                intervals.append((start, end))
    except (OSError, UnicodeDecodeError) as fault:
        raise TrajectoryError(f'{path}: cannot be read ({fault}); give a CSV file "start,end"') from fault
    return np.array(intervals, dtype=np.int64).reshape(-1, 2)
