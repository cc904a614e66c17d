"""A route is kept unless it is blocked or clearly longer; a robot too near to an obstacle escapes."""

import numpy as np
import pytest

from reward_planner.core.driving.replanner import Replanner, escape_path, path_length
from reward_planner.core.mapping.global_map import CostmapMasks, GlobalMap, LocalMap
from reward_planner.core.occupancy_map import FREE, OCCUPIED, GridFrame, OccupancyMap, clearance
from reward_planner.core.route.route import NoRoute
from reward_planner.core.safety.footprint import Footprint
from reward_planner.core.settings import DrivingSettings, PlannerSettings, RewardSettings
from shirube_core.geometry import SE2

FRAME = GridFrame(-1.0, -4.0, 0.1, 100, 80)
HERE = SE2(0.0, 0.0, 0.0)
GOAL = (8.0, 0.0)


class Floor:
    """A map that can be painted, and a replanner on it."""

    def __init__(self, mode='optimal', **settings):
        self.global_map = GlobalMap(0.1, 1_000_000)
        self.paint((-1.0, -4.0, 9.0, 4.0), FREE)
        planner = PlannerSettings(mode, **{'robot_radius': 0.2, **settings})
        self.replanner = Replanner(self.global_map, GOAL, planner, RewardSettings(), DrivingSettings())

    def paint(self, box, value):
        low, high = FRAME.cell_of([box[:2], box[2:]])
        observed = np.zeros(FRAME.shape, dtype=bool)
        observed[low[0] : high[0], low[1] : high[1]] = True
        self.global_map.write(LocalMap(FRAME, np.full(FRAME.shape, value, dtype=np.int8), observed))
        if hasattr(self, 'replanner'):
            self.replanner.update_map(FRAME)


def test_a_route_that_nothing_touches_is_kept_and_one_that_is_blocked_replaced_at_once():
    floor = Floor()
    floor.replanner.update(0.0, HERE)
    for k in range(1, 40):
        floor.paint((2.0 + 0.1 * k, 2.0, 2.1 + 0.1 * k, 2.5), OCCUPIED)
        floor.replanner.update(0.5 * k, HERE)
    assert floor.replanner.replan_count == 1
    assert path_length(floor.replanner.points_map) == pytest.approx(8.0, abs=0.2)
    floor.paint((4.0, -1.0, 4.5, 1.0), OCCUPIED)
    floor.replanner.update(19.55, HERE)
    assert floor.replanner.replan_count == 2
    assert np.abs(floor.replanner.points_map[:, 1]).max() > 1.2
    assert floor.replanner.costmap.clearance_at(floor.replanner.points_map[:-1]).min() > 0.3


def test_a_route_that_is_only_just_beaten_is_kept_and_one_that_is_clearly_beaten_is_left():
    floor = Floor()
    floor.paint((4.0, -4.0, 4.5, 0.6), OCCUPIED)
    floor.replanner.update(0.0, HERE)
    floor.paint((4.0, -1.2, 4.5, -0.2), FREE)  # hardly shorter
    floor.replanner.update(5.0, HERE)
    assert floor.replanner.replan_count == 1
    floor.paint((4.0, 0.6, 4.5, 3.6), OCCUPIED)
    floor.paint((4.0, -1.2, 4.5, -0.2), OCCUPIED)
    floor.replanner.update(6.0, HERE)
    assert floor.replanner.replan_count == 2
    floor.paint((4.0, -0.7, 4.5, 0.7), FREE)
    floor.replanner.update(6.2, HERE)
    assert floor.replanner.replan_count == 2  # not at every tick
    floor.replanner.update(8.0, HERE)
    assert floor.replanner.replan_count == 3
    assert path_length(floor.replanner.points_map) < 8.5


def least_gap(floor):
    """Least distance of the planned route from obstacles [m]."""
    floor.replanner.update(0.0, HERE)
    return floor.replanner.costmap.clearance_at(floor.replanner.points_map).min()


def test_routes_keep_distance_where_there_is_room_and_pass_where_there_is_not():
    floors = plain, costly = Floor(cost_scaling_factor=0.0), Floor()
    for floor in floors:
        floor.paint((3.0, -4.0, 5.0, 0.5), OCCUPIED)
    assert least_gap(plain) == pytest.approx(0.4)
    assert least_gap(costly) > 0.5
    assert path_length(costly.replanner.points_map) < 1.1 * path_length(plain.replanner.points_map)
    for floor in floors:
        floor.paint((-1.0, -4.0, 9.0, 4.0), FREE)
        floor.paint((3.0, -4.0, 5.0, -0.3), OCCUPIED)
        floor.paint((3.0, 0.4, 5.0, 4.0), OCCUPIED)
        floor.paint((-1.0, -4.0, -0.8, 4.0), OCCUPIED)
        floor.replanner.reset()
        assert least_gap(floor) == pytest.approx(0.4, abs=0.06)
        along = floor.replanner.points_map
        assert np.abs(along[(along[:, 0] > 3.0) & (along[:, 0] < 5.0), 1]).max() < 0.1


def test_a_cheaper_route_replaces_one_that_became_costly_though_not_blocked():
    floor = Floor()
    floor.replanner.update(0.0, HERE)
    for y in (-0.5, 0.4):
        floor.paint((1.0, y, 7.0, y + 0.1), OCCUPIED)
    floor.replanner.update(2.0, HERE)
    assert floor.replanner.replan_count == 2
    assert np.abs(floor.replanner.points_map[:, 1]).max() > 0.6


def test_routes_avoid_keepout_areas_and_unknown_cells_if_blocked():
    floor = Floor()
    mask = np.zeros((40, 10), dtype=np.int8)
    mask[:35] = OCCUPIED
    floor.global_map.masks = CostmapMasks(OccupancyMap(GridFrame(4.0, -2.0, 0.1, 10, 40), mask))
    floor.replanner.update(0.0, HERE)
    assert not floor.replanner.costmap.blocked[
        tuple(floor.replanner.costmap.frame.cell_of(floor.replanner.points_map).T)
    ].any()
    assert 1.5 < np.abs(floor.replanner.points_map[:, 1]).max() < 2.3
    for unknown, reason in (('free', None), ('blocked', NoRoute.GOAL_BLOCKED)):
        floor = Floor(unknown=unknown)
        floor.global_map.clear()
        floor.paint((-1.0, -4.0, 7.0, 4.0), FREE)
        floor.replanner.update(0.0, HERE)
        assert floor.replanner.no_route_reason is reason


LONG = (0.6, 0.15, -0.2, 0.15, -0.2, -0.15, 0.6, -0.15)


@pytest.mark.parametrize(('width', 'passes'), [(0.7, True), (0.3, False)])
def test_a_long_robot_fits_along_a_passage_but_not_around_its_corner(width, passes):
    """A circle around the footprint has a radius of 0.62 m, too much for both passages."""
    floor = Floor(footprint=LONG)
    low, high = -width / 2 - 0.05, width / 2 + 0.05
    for y, y_end in ((-4.0, low), (high, 4.0)):
        floor.paint((3.0, y, 5.0, y_end), OCCUPIED)
    floor.replanner.update(0.0, HERE)
    points = floor.replanner.points_map
    goes_through = np.abs(points[:, 1]).max() < 0.2
    assert goes_through == passes
    assert_footprint_is_free(floor, LONG)


def test_a_footprint_is_free_along_the_route_which_is_found_if_the_circle_around_it_has_one():
    counts = [0, 0, 0]
    for seed in range(12):
        rng = np.random.default_rng(seed)
        floors = Floor(footprint=LONG), Floor(robot_radius=0.62), Floor(robot_radius=0.15)
        for x, y, longer in zip(
            rng.uniform(0.8, 7.2, 20), rng.uniform(-3.5, 3.5, 20), rng.uniform(0.2, 2.5, 20), strict=True
        ):
            box = (x, y, x + 0.2, y + longer) if rng.random() < 0.5 else (x, y, x + longer, y + 0.2)
            for floor in floors:
                floor.paint(box, OCCUPIED)
        for floor in floors:
            for wall in ((-1.0, 3.8, 9.0, 4.0), (-1.0, -4.0, 9.0, -3.8), (-1.0, -4.0, -0.8, 4.0)):
                floor.paint(wall, OCCUPIED)
            for x, y in (HERE.x, HERE.y), GOAL:
                floor.paint((x - 0.7, y - 0.9, x + 0.7, y + 0.9), FREE)
            floor.replanner.update(0.0, HERE)
        assert_footprint_is_free(floors[0], LONG)
        polygon, around, within = (floor.replanner.no_route_reason is None for floor in floors)
        assert around <= polygon <= within
        counts = [count + found for count, found in zip(counts, (around, polygon, within), strict=True)]
    assert counts[0] < counts[1] <= counts[2], counts


@pytest.mark.parametrize(('end', 'reason'), [(8.9, None), (8.4, NoRoute.UNREACHABLE)])
def test_a_goal_where_the_footprint_does_not_fit_is_unreachable(end, reason):
    floor = Floor(footprint=LONG)
    for box in ((7.0, -0.7, 9.0, -0.4), (7.0, 0.4, 9.0, 0.7), (end, -0.7, end + 0.1, 0.7)):
        floor.paint(box, OCCUPIED)
    floor.replanner.update(0.0, HERE)
    assert floor.replanner.no_route_reason is reason


def assert_footprint_is_free(floor, corners):
    """Each obstacle is outside of the footprint at all points, in the direction of the chord."""
    outline, points = Footprint(corners, 0.0), floor.replanner.points_map
    frame, cells = floor.global_map.occupancy()
    obstacles = frame.centre_of(np.argwhere(cells == OCCUPIED))
    for k in range(1, len(points) - 1):
        ahead = points[min(k + 7, len(points) - 1)] - points[max(k - 7, 0)]
        x, y = ahead / np.hypot(*ahead)
        base = (obstacles - points[k]) @ np.array([[x, -y], [y, x]])
        near = base[np.hypot(*base.T) < 1.0]
        assert (outline.distances(near) > 0.04).all()


def test_why_there_is_no_route_is_reported_and_a_new_path_is_taken():
    floor = Floor()
    for wall in ((4.0, -4.0, 4.5, 4.0), (-1.0, 3.5, 9.0, 4.0), (-1.0, -4.0, 9.0, -3.5), (-1.0, -4.0, -0.5, 4.0)):
        floor.paint(wall, OCCUPIED)
    floor.replanner.update(0.0, HERE)
    assert floor.replanner.no_route_reason is NoRoute.UNREACHABLE
    floor.paint((4.0, -1.0, 4.5, 1.0), FREE)
    floor.replanner.update(2.0, HERE)
    assert floor.replanner.no_route_reason is None
    assert floor.replanner.replan_count == 1


def test_the_route_shrinks_as_the_robot_drives_and_a_robot_off_it_gets_another():
    floor = Floor()
    floor.replanner.update(0.0, HERE)
    floor.replanner.update(0.1, SE2(1.0, 0.05, 0.0))
    assert path_length(floor.replanner.points_map) == pytest.approx(7.0, abs=0.2)
    floor.replanner.update(0.2, SE2(1.0, 0.9, 0.0))
    assert floor.replanner.replan_count == 2


def test_the_reward_rule_decides_a_stretch_at_a_time():
    floor = Floor('reward')
    floor.replanner.update(0.0, HERE)
    assert path_length(floor.replanner.points_map) < 2.0
    x = 0.0
    while x < 8.0:
        x += 0.1
        floor.replanner.update(x, SE2(x, 0.0, 0.0))
    assert floor.replanner.points_map[-1].tolist() == list(GOAL)


def test_each_step_gains_clearance_and_the_last_is_free():
    rng = np.random.default_rng(3)
    found = 0
    for _ in range(50):
        occupied = rng.random((40, 40)) < 0.004
        room = clearance(occupied, 0.1)
        blocked = room <= 0.45
        inside = np.argwhere(blocked & (room > 0.0))
        start = tuple(int(n) for n in inside[rng.integers(len(inside))])
        out = escape_path(room, blocked, start)
        if out is None:
            continue
        found += 1
        along = room[out[:, 0], out[:, 1]]
        assert (np.diff(along) > 0.0).all()
        assert blocked[tuple(out[:-1].T)].all()
        assert not blocked[tuple(out[-1])]
        assert (np.abs(np.diff(out, axis=0)).max(axis=1) == 1).all()
    assert found > 25


def test_a_free_start_is_its_own_escape_path_and_a_passage_that_is_too_narrow_has_none():
    room = np.full((5, 5), 1.0, dtype=np.float32)
    assert escape_path(room, np.zeros((5, 5), dtype=bool), (2, 3)).tolist() == [[2, 3]]
    occupied = np.zeros((20, 9), dtype=bool)
    occupied[:, [0, 8]] = True
    room = clearance(occupied, 0.1)
    assert escape_path(room, room <= 0.6, (10, 2)) is None
    floor = Floor()
    for low, high in ((0.25, 0.5), (-0.5, -0.25)):
        floor.paint((-1.0, low, 3.0, high), OCCUPIED)
    floor.replanner.update(0.0, HERE)
    assert floor.replanner.no_route_reason is NoRoute.START_BLOCKED
