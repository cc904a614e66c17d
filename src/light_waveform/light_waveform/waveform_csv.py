"""Waveforms as CSV text: how programs that make light and programs that play it exchange what a lamp plays.

The header is ``t,level`` for a lamp of one part and ``t,level_a,level_b`` for one of two halves. A row tells from which
time [s] its levels hold, 0 dark to 1; the last row ends the period and repeats the levels of the first.
"""

from __future__ import annotations

import numpy as np

from light_waveform.light_waveform_error import LightWaveformError
from light_waveform.waveform import Waveform

_HEADERS = {1: 't,level', 2: 't,level_a,level_b'}
_REMEDY = f'the first line must be {_HEADERS[1]} or {_HEADERS[2]}, the others as many numbers'


def csv_of_waveform(waveform: Waveform) -> str:
    """Return one whole period as CSV text, from which `waveform_of_csv` gives the very same numbers."""
    times = [*waveform.times.tolist(), waveform.period]
    levels = [*waveform.levels.tolist(), waveform.levels[0].tolist()]
    rows = [
        ','.join([repr(time), *(f'{level:.17g}' for level in row)])
        for time, row in zip(times, levels, strict=True)
    ]
    return '\n'.join([_HEADERS[waveform.parts], *rows]) + '\n'


def waveform_of_csv(text: str) -> Waveform:
    """Return the waveform that CSV text tells.

    Raises:
        LightWaveformError: another header, a row that is no row of numbers, fewer than two rows, or numbers that are
            no waveform.
    """
    lines = [line.strip() for line in text.splitlines() if line.strip()]
    header = lines[0] if lines else ''
    if header not in _HEADERS.values():
        raise LightWaveformError(f'the waveform begins with {header[:40]!r}; {_REMEDY}')
    columns = header.count(',') + 1
    rows = [_row(number, line, columns) for number, line in enumerate(lines[1:], start=2)]
    if len(rows) < 2:
        raise LightWaveformError(
            'the waveform has no period; give one row a level and one that ends the period'
        )
    table = np.array(rows)
    return Waveform(table[:-1, 0], table[:-1, 1:], float(table[-1, 0]))


def _row(number: int, line: str, columns: int) -> list[float]:
    try:
        row = [float(word) for word in line.split(',')]
    except ValueError:
        row = []
    if len(row) != columns or not np.isfinite(row).all():
        raise LightWaveformError(f'line {number} of the waveform is {line[:40]!r}; {_REMEDY}')
    return row
