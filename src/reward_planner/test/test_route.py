"""Tests of routes as values."""

import numpy as np
import pytest

from reward_planner.core.occupancy_map import GridFrame
from reward_planner.core.route.route import Route


def test_a_route_is_given_in_metres_of_the_map_frame() -> None:
    frame = GridFrame(-1.0, 2.0, 0.5, 10, 10)
    route = Route(np.array([[0, 0], [0, 1], [1, 2]]), 1.0 + 2.0**0.5)
    np.testing.assert_allclose(route.points_map(frame), [[-0.75, 2.25], [-0.25, 2.25], [0.25, 2.75]])
    assert route.length_in_metres(frame) == pytest.approx(
        np.linalg.norm(np.diff(route.points_map(frame), axis=0), axis=1).sum()
    )
