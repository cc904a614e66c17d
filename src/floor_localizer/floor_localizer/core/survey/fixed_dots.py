"""Which dots of a survey are those of the map that is extended, and stay there."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from floor_localizer.core.survey.adjustment import place_dots
from floor_localizer.core.survey.dot_matching import nearest_pairs
from floor_localizer.core.survey.sighting_blocks import SightingBlock, SightingBlocks


def fix_dots(
    blocks: SightingBlocks,
    states: NDArray[np.float64],
    position: NDArray[np.float64],
    old: NDArray[np.float64],
    reach: float,
) -> None:
    """Fix the dots that lie on dots of a map, each on another one; of several the nearest.

    Args:
        blocks: without fixed dots.
        states: shape (k, 6), of all images.
        position: of the optical centre [m].
        old: shape (n, 2), the dots of the map [m].
        reach: a dot is no farther from the one it is [m].
    """
    nearest = np.full(len(old), np.inf)
    owner = np.full((len(old), 2), -1)
    for number, block in enumerate(blocks):
        dots, _ = place_dots(block, states, position)
        seen, known = nearest_pairs(old, dots, reach)
        distance = np.hypot(*(dots[seen] - old[known]).T)
        nearer = distance < nearest[known]
        nearest[known[nearer]] = distance[nearer]
        owner[known[nearer]] = np.column_stack([np.full(nearer.sum(), number), seen[nearer]])
    for number, block in enumerate(blocks):
        known = np.flatnonzero(owner[:, 0] == number)
        if len(known):
            fixed = block.fixed_dots.copy()
            fixed[owner[known, 1]] = old[known]
            blocks.put(number, SightingBlock(block.seen, fixed))
