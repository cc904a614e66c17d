"""What a lamp plays: brightness over time, one whole period of it."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike, NDArray


@dataclass(frozen=True)
class Waveform:
    """Brightness of a lamp's parts, played again and again. A level holds from its time to the next.

    Attributes:
        times: shape (n,), rising from 0 [s].
        levels: shape (n, parts), 0 to 1; one part, or the panel's two halves.
        period: length of the whole [s].
    """

    times: NDArray[np.float64]
    levels: NDArray[np.float64]
    period: float

    def integral(self, times: ArrayLike) -> NDArray[np.float64]:
        """Return the light given out from time 0 on.

        Args:
            times: shape (...,), any time [s].

        Returns:
            Shape (..., parts) [s].
        """
        rounds, rest = np.divmod(np.asarray(times, float), self.period)
        edges = np.append(self.times, self.period)
        light = np.vstack(
            [np.zeros(self.levels.shape[1]), np.cumsum(self.levels * np.diff(edges)[:, None], 0)]
        )
        parts = [rounds * total[-1] + np.interp(rest, edges, total) for total in light.T]
        return np.stack(parts, -1)

    def exposed(self, starts: ArrayLike, exposure: float) -> NDArray[np.float64]:
        """Return the mean brightness that a pixel or a row sees.

        Args:
            starts: shape (...,), when its exposure begins [s].
            exposure: how long it lasts [s].

        Returns:
            Shape (..., parts), 0 to 1.
        """
        starts = np.asarray(starts, float)
        return (self.integral(starts + exposure) - self.integral(starts)) / exposure


def waveform_of_steps(durations: ArrayLike, levels: ArrayLike) -> Waveform:
    """Join steps to a waveform; neighbours of the same levels become one.

    Args:
        durations: shape (n,) [s].
        levels: shape (n,) for one part, or (n, parts).
    """
    durations, levels = np.asarray(durations, float), np.asarray(levels, float)
    levels = levels.reshape(len(durations), -1)
    starts = np.concatenate([[0.0], np.cumsum(durations)])
    kept = np.append(True, np.any(np.diff(levels, axis=0) != 0.0, axis=1))
    return Waveform(starts[:-1][kept], levels[kept], float(starts[-1]))
