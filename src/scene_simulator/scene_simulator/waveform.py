"""How bright a lamp is over time: one period of a step function, and its exact mean over exposures."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import numpy as np
from numpy.typing import ArrayLike, NDArray

from scene_simulator.scene_error import SceneError


@dataclass(frozen=True, eq=False)
class Waveform:
    """One whole period of a lamp's light; each level holds until the next time.

    Attributes:
        times: shape (n,), rising from 0 [s].
        levels: shape (n, parts), 0 (dark) to 1, for each part of the lamp; one part or two.
        period: length of the period [s], above the last time.
    """

    times: NDArray[np.float64]
    levels: NDArray[np.float64]
    period: float

    def __post_init__(self) -> None:
        """Refuse what is not a waveform.

        Raises:
            SceneError: arrays of other shapes, times that do not rise from 0, levels outside 0 to 1.
        """
        times, levels = self.times, self.levels
        if times.ndim != 1 or levels.ndim != 2 or len(times) != len(levels) or levels.shape[1] not in (1, 2):
            raise SceneError(
                f'a waveform has n times and n x 1 or n x 2 levels, not {times.shape} and {levels.shape}'
            )
        ends = np.append(times, self.period)
        if len(times) == 0 or times[0] != 0.0 or not np.isfinite(ends).all() or (np.diff(ends) <= 0.0).any():
            raise SceneError('the times of a waveform must rise from 0 and end before its period')
        if not ((levels >= 0.0) & (levels <= 1.0)).all():
            raise SceneError('a level of a waveform is outside 0 to 1')

    @property
    def parts(self) -> int:
        """Number of parts of the lamp that have a level of their own."""
        return int(self.levels.shape[1])

    def mean_levels(self, starts: ArrayLike, stops: ArrayLike) -> NDArray[np.float64]:
        """Return the exact mean over windows of time: the integral of the step function over their length.

        Args:
            starts: array-like, any shape, waveform times [s]; the waveform repeats for ever.
            stops: array-like, same shape; where it equals the start, the level at that instant counts.

        Returns:
            array, the shape of the windows and one more axis for the parts.
        """
        # From the period in which the window starts, so that no digits are lost far from zero.
        begin = np.mod(np.asarray(starts, dtype=np.float64), self.period)
        length = np.asarray(stops, dtype=np.float64) - np.asarray(starts, dtype=np.float64)
        light = self._integral(begin + length) - self._integral(begin)
        with np.errstate(divide='ignore', invalid='ignore'):
            return np.where(length[..., None] > 0.0, light / length[..., None], self._level(begin))

    def _level(self, times: NDArray[np.float64]) -> NDArray[np.float64]:
        """Return the levels at times within the first period [s]."""
        return self.levels[np.searchsorted(self.times, times, side='right') - 1]

    def _integral(self, times: NDArray[np.float64]) -> NDArray[np.float64]:
        """Return the integral of the levels from 0 to times [s]."""
        turns = np.floor(times / self.period)
        rest = times - turns * self.period
        step = np.searchsorted(self.times, rest, side='right') - 1
        within = self._sums[step] + (rest - self.times[step])[..., None] * self.levels[step]
        return np.asarray(turns[..., None] * self._sums[-1] + within)

    @cached_property
    def _sums(self) -> NDArray[np.float64]:
        """Integral from 0 to each time and to the period, shape (n + 1, parts) [s]."""
        steps = np.diff(np.append(self.times, self.period))[:, None] * self.levels
        return np.concatenate([np.zeros((1, self.parts)), np.cumsum(steps, axis=0)])


def steady(parts: int = 1) -> Waveform:
    """Return the light of a lamp that carries no code."""
    return Waveform(np.zeros(1), np.ones((1, parts)), 1.0)


def square_wave(frequency: float) -> Waveform:
    """Return a lamp that is on for the first half of each period, of a frequency [Hz]."""
    return Waveform(np.array([0.0, 0.5 / frequency]), np.array([[1.0], [0.0]]), 1.0 / frequency)


def quadrature(frequency: float) -> Waveform:
    """Return a lamp of two parts with square waves of a frequency [Hz], the second a quarter period late."""
    levels = np.array([[1.0, 0.0], [1.0, 1.0], [0.0, 1.0], [0.0, 0.0]])
    return Waveform(np.arange(4) * 0.25 / frequency, levels, 1.0 / frequency)


def mains_flicker(frequency: float = 100.0, depth: float = 0.3) -> Waveform:
    """Return a room lamp that flickers with the mains.

    Args:
        frequency: of the flicker, twice the mains' [Hz].
        depth: share of the light that is missing at the darkest.
    """
    middles = (np.arange(64) + 0.5) / 64.0
    levels = 1.0 - depth * np.square(np.cos(np.pi * middles))
    return Waveform(np.arange(64) / 64.0 / frequency, levels[:, None], 1.0 / frequency)
