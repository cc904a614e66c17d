"""Inflation: costs of cells that decay with the distance from obstacles, as in Nav2's costmap_2d."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from reward_planner.core.route.route import COST_MAX, LETHAL


def inflation_costs(
    clearance: NDArray[np.float32], inscribed_radius: float, inflation_radius: float, scaling_factor: float
) -> NDArray[np.uint8]:
    """Return costs by the distance d from the nearest obstacle, same shape.

    They are `LETHAL` up to the inscribed radius r [m], 252 exp(-k (d - r)) up to the inflation radius [m] with the
    scaling factor k [1/m], and 0 beyond or if k is 0.
    """
    costs = np.zeros(clearance.shape, dtype=np.uint8)
    if scaling_factor > 0.0:
        is_near = clearance <= inflation_radius
        decay = np.exp(-scaling_factor * np.maximum(clearance[is_near] - inscribed_radius, 0.0))
        costs[is_near] = np.rint(COST_MAX * decay)
    costs[clearance <= inscribed_radius] = LETHAL
    return costs
