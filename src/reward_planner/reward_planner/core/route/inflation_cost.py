"""Inflation: costs of cells that decay with the distance from obstacles, as in Nav2's costmap_2d."""

import numpy as np
from numpy.typing import NDArray

from reward_planner.core.route.route import COST_MAX, LETHAL
from reward_planner.core.settings import PlannerSettings

_ROUNDING = 1e-5  # clearances are computed in single precision [m]


def inflation_costs(
    clearance: NDArray[np.float32], inscribed_radius: float, settings: PlannerSettings
) -> NDArray[np.uint8]:
    """Return costs by the distance d from the nearest obstacle [m], same shape.

    They are `LETHAL` up to the inscribed radius r [m], 252 exp(-k (d - r)) up to inflation_radius with
    k = cost_scaling_factor, and 0 beyond or if k is 0.
    """
    costs = np.zeros(clearance.shape, dtype=np.uint8)
    if settings.cost_scaling_factor > 0.0:
        is_near = clearance <= settings.inflation_radius + _ROUNDING
        distances = clearance[is_near] - np.float32(inscribed_radius)
        costs[is_near] = np.rint(COST_MAX * np.exp(-settings.cost_scaling_factor * np.maximum(distances, 0.0)))
    costs[clearance <= inscribed_radius + _ROUNDING] = LETHAL
    return costs
