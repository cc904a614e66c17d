"""Table 1 of the paper: rewards and penalties of a step."""

from __future__ import annotations

from dataclasses import astuple, dataclass

import numpy as np
from numpy.typing import NDArray

from shirube_core.settings import setting


@dataclass(frozen=True)
class RewardTable:
    """Rewards and penalties of one step, in the rows of the table."""

    advance: float = setting(
        100.0,
        'row 1: a free step earns this/L - L, L cells from the goal',
        minimum=0.0,
        maximum=1e6,
    )
    collision: float = setting(-1000.0, 'row 2: the step hits an obstacle', minimum=-1e6, maximum=0.0)
    outside: float = setting(-1000.0, 'row 3: the step leaves the map', minimum=-1e6, maximum=0.0)
    visited: float = setting(-250.0, 'row 4: the step enters a visited cell', minimum=-1e6, maximum=0.0)
    detour: float = setting(
        -100.0,
        'row 5: neither this step nor the last one goes straight to the goal',
        minimum=-1e6,
        maximum=0.0,
    )

    def reward_values(self) -> NDArray[np.float64]:
        """Return the rows as an array for numba kernels, shape (5,)."""
        return np.array(astuple(self), dtype=np.float64)
