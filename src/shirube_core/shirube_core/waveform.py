"""Brightness of a lamp over time: one period of a step function, and its exact mean over exposures.

As CSV text, the exchange format between encoders and simulators, it has the header ``t,level`` for a lamp of one part
and ``t,level_a,level_b`` for a panel of two halves. Each row gives the time [s] from which its levels (0 dark, 1 full)
apply; the last row ends the period and repeats the first levels.
"""

from dataclasses import dataclass
from functools import cached_property

import numpy as np
from numpy.typing import ArrayLike, NDArray

_HEADERS = {1: 't,level', 2: 't,level_a,level_b'}
_REMEDY = f'the first line must be {_HEADERS[1]} or {_HEADERS[2]}, the others as many numbers'


class LightWaveformError(ValueError):
    """Invalid waveform; the message is one line with the cause."""


@dataclass(frozen=True, eq=False)
class Waveform:
    """One period of a lamp's light, repeated forever; each level holds until the next time.

    Attributes:
        times: switching times, shape (n,), increasing from 0 [s].
        levels: brightness, shape (n, parts), 0 (dark) to 1; one part, or the two halves of a panel.
        period: length of the period [s], greater than the last time.
    """

    times: NDArray[np.float64]
    levels: NDArray[np.float64]
    period: float

    def __post_init__(self) -> None:
        """Validate shapes, times and levels.

        Raises:
            LightWaveformError: wrong shapes, times that do not increase from 0 and end before the period,
                levels outside 0 to 1.
        """
        times, levels = self.times, self.levels
        if times.ndim != 1 or levels.ndim != 2 or len(times) != len(levels) or levels.shape[1] not in (1, 2):
            raise LightWaveformError(
                f'a waveform has n times and n x 1 or n x 2 levels, not {times.shape} and {levels.shape}'
            )
        ends = np.append(times, self.period)
        if len(times) == 0 or times[0] != 0.0 or not np.isfinite(ends).all() or (np.diff(ends) <= 0.0).any():
            raise LightWaveformError('the times of a waveform must rise from 0 and end before its period')
        if not ((levels >= 0.0) & (levels <= 1.0)).all():
            raise LightWaveformError('a level of a waveform is outside 0 to 1')

    @property
    def parts(self) -> int:
        """Number of parts of the lamp that are switched independently."""
        return int(self.levels.shape[1])

    def levels_at(self, times: ArrayLike) -> NDArray[np.float64]:
        """Return the levels at given times.

        Args:
            times: array-like, any shape [s]; the waveform is periodic, also before 0.

        Returns:
            array, shape (*times.shape, parts), 0 to 1.
        """
        phase = np.mod(np.asarray(times, dtype=np.float64), self.period)
        return np.array(self.levels[np.searchsorted(self.times, phase, side='right') - 1])

    def mean_levels(self, starts: ArrayLike, stops: ArrayLike) -> NDArray[np.float64]:
        """Return the exact mean over time windows: the integral of the step function over their length.

        Args:
            starts: start of each window, array-like, any shape [s].
            stops: end of each window, same shape, not before the start [s]; where it equals the start, the level
                at that instant is returned.

        Returns:
            array, shape (*starts.shape, parts), 0 to 1.
        """
        begin = np.asarray(starts, dtype=np.float64)
        length = (np.asarray(stops, dtype=np.float64) - begin)[..., None]
        # Reduce to the first period, so that no precision is lost far from zero.
        first = np.mod(begin, self.period)
        light = self._integral(first + length[..., 0]) - self._integral(first)
        means = np.divide(light, length, out=self.levels_at(begin), where=length > 0.0)
        return np.asarray(np.clip(means, 0.0, 1.0))

    def exposure_means(self, starts: ArrayLike, exposure: float) -> NDArray[np.float64]:
        """Return the mean levels over exposures that begin at ``starts`` [s] and last ``exposure`` [s]."""
        begin = np.asarray(starts, dtype=np.float64)
        return self.mean_levels(begin, begin + exposure)

    def _integral(self, times: NDArray[np.float64]) -> NDArray[np.float64]:
        """Return the integral of the levels from 0 to times, shape (..., parts) [s]."""
        whole_periods = np.floor(times / self.period)
        # Rounding of the quotient at the end of a period must not give a negative phase.
        phase = np.maximum(times - whole_periods * self.period, 0.0)
        step = np.searchsorted(self.times, phase, side='right') - 1
        partial = self._cumulative[step] + (phase - self.times[step])[..., None] * self.levels[step]
        return np.asarray(whole_periods[..., None] * self._cumulative[-1] + partial)

    @cached_property
    def _cumulative(self) -> NDArray[np.float64]:
        """Integral from 0 to each time and to the period, shape (n + 1, parts) [s]."""
        steps = np.diff(np.append(self.times, self.period))[:, None] * self.levels
        return np.concatenate([np.zeros((1, self.parts)), np.cumsum(steps, axis=0)])


def waveform_from_steps(durations: ArrayLike, levels: ArrayLike) -> Waveform:
    """Build one period from steps; adjacent steps with equal levels are merged.

    Args:
        durations: duration of each step, array-like, shape (n,) [s].
        levels: brightness, array-like, shape (n,) for a lamp of one part, or (n, parts), 0 to 1.

    Raises:
        LightWaveformError: wrong shapes, no step, a duration that is not positive, levels outside 0 to 1.
    """
    steps = np.asarray(durations, dtype=np.float64)
    values = np.asarray(levels, dtype=np.float64)
    if steps.ndim != 1 or len(steps) == 0 or values.ndim not in (1, 2) or len(values) != len(steps):
        raise LightWaveformError(f'steps have n durations and n levels, not {steps.shape} and {values.shape}')
    if not (steps > 0.0).all():
        raise LightWaveformError('a step of a waveform must last longer than 0 s')
    values = values.reshape(len(steps), -1)
    ends = np.cumsum(steps)
    changes = np.concatenate([[True], (np.diff(values, axis=0) != 0.0).any(axis=1)])
    return Waveform(np.concatenate([[0.0], ends[:-1]])[changes], values[changes], float(ends[-1]))


def steady_light(parts: int = 1) -> Waveform:
    """Return the waveform of a lamp that is constantly on."""
    return waveform_from_steps([1.0], np.ones((1, parts)))


def waveform_to_csv(waveform: Waveform) -> str:
    """Return one period as CSV text; `waveform_from_csv` restores it exactly."""
    times = [*waveform.times.tolist(), waveform.period]
    levels = [*waveform.levels.tolist(), waveform.levels[0].tolist()]
    rows = [
        ','.join([repr(time), *(f'{level:.17g}' for level in row)]) for time, row in zip(times, levels, strict=True)
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
