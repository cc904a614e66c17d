"""D* Lite against searches from scratch."""

import numpy as np
import pytest
from grid_maps import GRID_MAPS
from grid_world import GridWorld, is_traversable
from scipy.sparse import csr_array
from scipy.sparse.csgraph import dijkstra

from reward_planner.core.reward_planner_error import RewardPlannerError
from reward_planner.core.route import d_star_lite, route
from reward_planner.core.route.d_star_lite import DStarLite
from reward_planner.core.route.route import COST_MAX, DIAGONAL, LETHAL, STRAIGHT, NoRoute, Route
from reward_planner.core.route.shortest_route import shortest_route


def assert_as_from_scratch(routes: DStarLite, blocked, start, goal) -> Route | NoRoute:
    np.testing.assert_array_equal(routes.blocked, blocked)
    repaired, anew = routes.route_from(start), shortest_route(blocked, start, goal)
    if isinstance(anew, NoRoute):
        assert repaired == anew
    else:
        assert repaired.length == pytest.approx(anew.length, abs=1e-9)
        assert (tuple(repaired.cells[0]), tuple(repaired.cells[-1])) == (start, goal)
        assert is_traversable(blocked, repaired.cells)
    return repaired


@pytest.mark.parametrize('seed', range(30))
def test_routes_are_those_from_scratch_whatever_changes_and_wherever_the_robot_jumps(seed: int) -> None:
    rng = np.random.default_rng(seed)
    blocked = rng.random(rng.integers(3, 25, 2)) < rng.choice([0.0, 0.1, 0.3])
    cells = np.argwhere(np.ones(blocked.shape))
    goal = tuple(rng.choice(cells).tolist())
    routes = DStarLite(blocked, goal)
    for _ in range(40):
        chosen = rng.choice(cells, rng.integers(0, 6))
        now = rng.random(len(chosen)) < 0.5
        routes.update_cells(chosen, now)
        blocked[tuple(chosen.T)] = now
        assert_as_from_scratch(routes, blocked, tuple(rng.choice(cells).tolist()), goal)


def edge_costs(costs, multiplier: float) -> csr_array:
    """The graph of the grid, in the planner's units: an independent statement of what a step costs."""
    rows, columns = costs.shape
    weight = round(multiplier / (2 * COST_MAX) * 2**20)
    edges = []
    for row, column in np.argwhere(costs <= COST_MAX).tolist():
        for down, right in ((0, 1), (1, 0), (1, 1), (1, -1)):
            to = row + down, column + right
            if not (to[0] < rows and 0 <= to[1] < columns):
                continue
            if max(costs[to], costs[row, to[1]], costs[to[0], column]) <= COST_MAX:
                step = DIAGONAL if down and right else STRAIGHT
                both = int(costs[row, column]) + int(costs[to])
                edges.append((row * columns + column, to[0] * columns + to[1], step + (step * weight * both >> 20)))
    begins, ends, steps = np.array(edges or [(0, 0, 0)]).T
    indices = begins.astype(np.int32), ends.astype(np.int32)  # scipy 1.11 knows no others
    return csr_array((steps.astype(float), indices), (costs.size, costs.size))


@pytest.mark.parametrize('multiplier', [0.0, 2.0, 10.0])
@pytest.mark.parametrize('seed', range(4))
def test_routes_cost_what_dijkstra_finds_whatever_costs_change(seed: int, multiplier: float) -> None:
    rng = np.random.default_rng(seed)
    costs = rng.choice([0, 0, 5, 60, COST_MAX, LETHAL], rng.integers(3, 18, 2)).astype(np.uint8)
    goal = tuple(rng.choice(np.argwhere(costs <= COST_MAX)).tolist())
    routes = DStarLite(costs, goal, multiplier)
    for _ in range(12):
        graph = edge_costs(costs, multiplier)
        truth = dijkstra(graph, directed=False, indices=goal[0] * costs.shape[1] + goal[1])
        start = tuple(rng.choice(np.argwhere(costs <= COST_MAX)).tolist())
        route, least = routes.route_from(start), truth[start[0] * costs.shape[1] + start[1]]
        if isinstance(route, NoRoute):
            assert least == np.inf
        else:
            numbers = route.cells @ (costs.shape[1], 1)
            both_ways = graph + graph.T
            assert sum(both_ways[a, b] for a, b in zip(numbers, numbers[1:], strict=False)) == least
            assert tuple(route.cells[-1].tolist()) == goal
        cells = rng.integers(0, costs.shape, (rng.integers(0, 9), 2))
        cells = np.unique(cells[(cells != goal).any(axis=1)], axis=0)
        new = rng.choice([0, 30, 200, LETHAL], len(cells)).astype(np.uint8)
        routes.update_cells(cells, new)
        costs[tuple(cells.T)] = new


@pytest.mark.parametrize('kind', GRID_MAPS)
def test_a_drive_through_unknown_terrain_replans_as_from_scratch(kind: str) -> None:
    occupied = GRID_MAPS[kind](60, 7)
    rng = np.random.default_rng(3)
    for ends in rng.permutation(np.argwhere(~occupied))[:8].reshape(4, 2, 2).tolist():
        cell, goal = (tuple(end) for end in ends)
        if isinstance(shortest_route(occupied, cell, goal), NoRoute):
            continue
        known, world = np.zeros_like(occupied), GridWorld(occupied)
        routes = DStarLite(known, goal)
        while cell != goal:
            seen, are_occupied = world.observe(cell, 6.0)
            routes.update_cells(seen, are_occupied)
            known[tuple(seen.T)] = are_occupied
            route = assert_as_from_scratch(routes, known, cell, goal)
            cell = tuple(route.cells[1].tolist())
            assert not occupied[cell]


def test_a_goal_that_is_walled_in_is_reported_and_reached_once_the_wall_is_gone() -> None:
    routes = DStarLite(np.zeros((20, 20), dtype=bool), (10, 10))
    around = [(r, c) for r in range(8, 13) for c in range(8, 13) if max(abs(r - 10), abs(c - 10)) == 2]
    assert isinstance(routes.route_from((0, 0)), Route)
    routes.update_cells(around, True)
    assert routes.route_from((0, 0)) == NoRoute.UNREACHABLE
    routes.update_cells([(10, 10)], True)
    assert routes.route_from((0, 0)) == NoRoute.GOAL_BLOCKED
    routes.update_cells([*around, (10, 10)], False)
    assert routes.route_from((0, 0)).length == pytest.approx(10 * 2**0.5)


def test_a_goal_outside_is_reported_a_cell_outside_refused_and_the_callers_map_copied() -> None:
    blocked = np.zeros((5, 5), dtype=bool)
    assert DStarLite(blocked, (5, 0)).route_from((0, 0)) == NoRoute.GOAL_OUTSIDE
    routes = DStarLite(blocked, (4, 4))
    with pytest.raises(RewardPlannerError, match='outside'):
        routes.update_cells([(0, -1)], [True])
    blocked[:] = True
    assert isinstance(routes.route_from((0, 0)), Route)


def test_changes_while_no_route_is_asked_for_take_no_more_than_a_search_from_scratch(monkeypatch) -> None:
    monkeypatch.setattr(d_star_lite, '_CHANGES_MAX', 500)
    rng, routes = np.random.default_rng(1), DStarLite(np.zeros((30, 30), dtype=bool), (29, 29))
    assert isinstance(routes.route_from((0, 0)), Route)
    for _ in range(200):
        routes.update_cells(rng.integers(1, 29, (20, 2)), rng.random(20) < 0.3)
        assert sum(map(len, routes._changed)) <= 500
    found, wanted = routes.route_from((0, 0)), shortest_route(routes.blocked, (0, 0), (29, 29))
    assert found.length == pytest.approx(wanted.length)


def test_a_route_avoids_what_an_obstacle_hides_unless_the_way_around_is_long() -> None:
    costs, others = np.full((40, 30), 150, dtype=np.uint8), np.arange(COST_MAX)
    costs[10:14, :20] = COST_MAX
    searches = [(DStarLite(route.travel_costs(costs), (20, k), 2.0 * route.HIDDEN_FACTOR), (0, k)) for k in (18, 0)]
    met = [(costs[tuple(search.route_from(start).cells.T)] == COST_MAX).any() for search, start in searches]
    assert met == [False, True]
    np.testing.assert_allclose(route.HIDDEN_FACTOR * route.travel_costs(others), others, atol=0.5 * route.HIDDEN_FACTOR)
