"""Planning on a static map."""

import numpy as np
import pytest

from reward_planner.commands.plan import plan_on_map
from reward_planner.core.occupancy_map import GridFrame, OccupancyMap, inflate_obstacles
from reward_planner.core.planner_settings import PlannerSettings, RewardSettings
from reward_planner.core.route.route import NoRoute, Route
from scene_simulator.grid_maps import maze, rooms
from scene_simulator.grid_truth import distances_from

WALLS = rooms(100, 3, room=33, door=8, closed_fraction=0.0)
GRID = OccupancyMap(GridFrame(-2.5, -2.5, 0.05, 100, 100), np.where(WALLS, 100, -1).astype(np.int8))
START, GOAL = (-2.2, -2.2), (2.1, 2.1)


def test_the_optimal_route_is_the_shortest_for_a_robot_of_this_size() -> None:
    route = plan_on_map(GRID, START, GOAL, PlannerSettings(robot_radius=0.12), RewardSettings())
    assert isinstance(route, Route)
    start, goal = (tuple(cell) for cell in GRID.frame.cell_of([START, GOAL]).tolist())
    truth = distances_from(inflate_obstacles(WALLS, 0.05, 0.12), start)[goal]
    assert route.length_in_metres(GRID.frame) == pytest.approx(0.05 * truth)


def test_the_reward_rule_arrives_with_counted_visits() -> None:
    reward = RewardSettings(visits='counted')
    route = plan_on_map(GRID, START, GOAL, PlannerSettings(mode='reward', robot_radius=0.1), reward)
    assert isinstance(route, Route)


def test_a_rule_that_goes_around_gives_up_and_says_so() -> None:
    walls = maze(61, 2, corridor=3)
    grid = OccupancyMap(GridFrame(0.0, 0.0, 1.0, 61, 61), np.where(walls, 100, 0).astype(np.int8))
    greedy = RewardSettings(virtual_steps_max=0)
    route = plan_on_map(grid, (2.0, 2.0), (58.0, 58.0), PlannerSettings('reward', 0.0), greedy)
    assert route == NoRoute.GAVE_UP
