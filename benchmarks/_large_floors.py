"""Floors larger than the paper's that hold the paper's floor in a corner, so that its views are views of them too."""

from __future__ import annotations

import math

import numpy as np
from _paper_views import FLOOR_DOTS, FLOOR_SIZE, paper_floor
from numpy.typing import NDArray


def large_floor(times: int, seed: int) -> NDArray[np.float64]:
    """Return the dots of a floor of so many times the paper's area and of its density, shape (times * 91582, 2) [m].

    The first 91 582 are the paper's floor; the others are uniformly random on the rest.
    """
    paper = paper_floor(seed)
    size = np.array(FLOOR_SIZE) * math.sqrt(times)
    wanted = (times - 1) * FLOOR_DOTS
    if wanted == 0:
        return paper
    # A share 1 / times of the draws falls on the paper's floor and is left out.
    draws = int(wanted * times / (times - 1) + 10.0 * math.sqrt(wanted) + 100.0)
    dots = np.random.default_rng([seed, times]).uniform((0.0, 0.0), size, (draws, 2))
    return np.vstack([paper, dots[(dots > FLOOR_SIZE).any(axis=1)][:wanted]])
