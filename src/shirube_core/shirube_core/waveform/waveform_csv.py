"""Waveforms as CSV text, the exchange format between encoders and simulators.

The header is ``t,level`` for a lamp of one part and ``t,level_a,level_b`` for a panel of two halves. Each row gives the
time [s] from which its levels (0 dark, 1 full) apply; the last row ends the period and repeats the first levels.
"""

from __future__ import annotations

import numpy as np

from shirube_core.waveform.light_waveform_error import LightWaveformError
from shirube_core.waveform.waveform import Waveform

_HEADERS = {1: 't,level', 2: 't,level_a,level_b'}
_REMEDY = f'the first line must be {_HEADERS[1]} or {_HEADERS[2]}, the others as many numbers'


def waveform_to_csv(waveform: Waveform) -> str:
    """Return one period as CSV text; `waveform_from_csv` restores it exactly."""
    times = [*waveform.times.tolist(), waveform.period]
    levels = [*waveform.levels.tolist(), waveform.levels[0].tolist()]
    rows = [
        ','.join([repr(time), *(f'{level:.17g}' for level in row)])
        for time, row in zip(times, levels, strict=True)
    ]
    return '\n'.join([_HEADERS[waveform.parts], *rows]) + '\n'


def waveform_from_csv(text: str) -> Waveform:
    """Parse a waveform from CSV text.

    Raises:
        LightWaveformError: unknown header, malformed row, fewer than two rows, or an invalid waveform.
    """
    lines = [line.strip() for line in text.splitlines() if line.strip()]
    header = lines[0] if lines else ''
    if header not in _HEADERS.values():
        raise LightWaveformError(f'the waveform begins with {header[:40]!r}; {_REMEDY}')
    columns = header.count(',') + 1
    rows = [_parse_row(number, line, columns) for number, line in enumerate(lines[1:], start=2)]
    if len(rows) < 2:
        raise LightWaveformError(
            'the waveform has no period; give one row per level and a last row that ends the period'
        )
    table = np.array(rows)
    return Waveform(table[:-1, 0], table[:-1, 1:], float(table[-1, 0]))


def _parse_row(number: int, line: str, columns: int) -> list[float]:
    try:
        row = [float(cell) for cell in line.split(',')]
    except ValueError:
        row = []
    if len(row) != columns or not np.isfinite(row).all():
        raise LightWaveformError(f'line {number} of the waveform is {line[:40]!r}; {_REMEDY}')
    return row
