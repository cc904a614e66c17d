"""The lookahead point, the free distance ahead, steering and speed limits."""

from dataclasses import replace

import numpy as np
import pytest

from reward_planner.core.driving.drive_state import Velocity, VelocitySmoother
from reward_planner.core.driving.inflated_costmap import InflatedCostmap
from reward_planner.core.driving.path_following import (
    braking_speed_limit,
    check_path_ahead,
    lookahead_point,
    obstacle_speed_limit,
    turn_rate_for_angle,
    velocity_towards,
)
from reward_planner.core.mapping.global_map import GlobalMap, LocalMap
from reward_planner.core.occupancy_map import FREE, OCCUPIED, UNKNOWN, GridFrame
from reward_planner.core.settings import DrivingSettings
from shirube_core.geometry import SE2

CORNER = np.array([(0.1 * k, 0.0) for k in range(11)] + [(1.0, 0.1 * k) for k in range(1, 11)])


def costmap_with(boxes, unknown=(0.0, 0.0, 0.0, 0.0)):
    frame = GridFrame(-3.0, -3.0, 0.1, 60, 60)
    cells = np.full(frame.shape, FREE, dtype=np.int8)
    for x0, y0, x1, y1 in boxes:
        low, high = frame.cell_of([(x0, y0), (x1, y1)])
        cells[low[0] : high[0], low[1] : high[1]] = OCCUPIED
    low, high = frame.cell_of([unknown[:2], unknown[2:]])
    cells[low[0] : high[0], low[1] : high[1]] = UNKNOWN
    global_map = GlobalMap(0.1, 1_000_000)
    global_map.write(LocalMap(frame, cells, np.ones(frame.shape, dtype=bool)))
    costmap = InflatedCostmap(0.2, 1.0)
    costmap.cover(global_map, [(0.0, 0.0)])
    return costmap


def test_corners_are_cut_where_nothing_is_in_the_way():
    assert lookahead_point(costmap_with([]), SE2(0.0, 0.0, 0.0), CORNER, 1.6) == pytest.approx((1.0, 0.6), abs=0.11)


@pytest.mark.parametrize('unknown', [(0.0, 0.0, 0.0, 0.0), (1.1, 0.2, 1.4, 1.0)])
def test_corners_are_not_cut_past_an_obstacle(unknown):
    costmap = costmap_with([(0.3, 0.3, 0.7, 0.9), (1.4, 0.2, 1.5, 1.0)], unknown)
    waypoint = lookahead_point(costmap, SE2(0.0, 0.0, 0.0), CORNER, 1.6)
    line = np.linspace(0.0, 1.0, 200)[:, None] * waypoint
    assert costmap.clearance_at(line).min() >= 0.2
    assert waypoint[1] < 0.3


def test_a_robot_with_too_little_clearance_gains_it_before_it_cuts_a_corner():
    costmap = costmap_with([(0.3, 0.3, 0.7, 0.9)])
    waypoint = lookahead_point(costmap, SE2(0.55, 0.15, 0.0), CORNER, 1.6)
    way = np.linspace(0.0, 1.0, 50)[:, None] * (waypoint - (0.55, 0.15)) + (0.55, 0.15)
    assert (np.diff(costmap.clearance_at(way)) >= -1e-6)[costmap.clearance_at(way)[1:] < 0.2].all()
    assert velocity_towards(0.2, 0.4, DrivingSettings()).forward > 0.2
    assert velocity_towards(0.2, 0.4, DrivingSettings(), is_held=True).forward == 0.0


def test_where_no_point_is_seen_it_is_the_next_one():
    costmap = costmap_with([(-0.5, -0.4, 1.5, -0.2)])
    assert lookahead_point(costmap, SE2(0.0, -0.9, 0.0), CORNER, 1.0).tolist() == [0.1, 0.0]


def test_a_route_that_comes_back_to_the_robot_leads_it_away_first():
    there = [(0.1 * k, 0.0) for k in range(4)]
    back = [*there, (0.3, 0.1), (0.2, 0.1), (0.1, 0.1), (0.02, 0.01)]
    waypoint = lookahead_point(costmap_with([]), SE2(0.02, 0.01, 0.0), np.array(back), 1.6)
    assert np.hypot(*(waypoint - (0.02, 0.01))) >= 0.1


def test_free_ahead_ends_before_the_obstacle():
    costmap = costmap_with([(1.5, -1.0, 1.8, 1.0)])
    free, least = check_path_ahead(costmap, SE2(0.0, 0.0, 0.0), 0.3, 2.5)
    assert free == pytest.approx(1.2, abs=0.11)
    assert least >= 0.3
    assert check_path_ahead(costmap, SE2(0.0, 0.0, 3.1), 0.3, 2.5)[0] == pytest.approx(2.5)


def test_a_robot_on_an_obstacle_may_leave_it_but_go_no_deeper():
    costmap = costmap_with([(0.0, -0.5, 1.0, 0.5)])
    outward, _ = check_path_ahead(costmap, SE2(0.95, 0.0, 0.0), 0.3, 1.0)
    deeper, _ = check_path_ahead(costmap, SE2(0.95, 0.0, 3.1416), 0.3, 1.0)
    assert deeper < 0.2
    assert outward > 0.9


SETTINGS = DrivingSettings()


@pytest.mark.parametrize('angle', [3.1, -1.0, 0.2])
def test_a_turn_ends_without_overshoot(angle):
    ramp, left = VelocitySmoother(SETTINGS), angle
    for _ in range(400):
        left -= 0.02 * ramp.step_toward(Velocity(0.0, turn_rate_for_angle(left, SETTINGS)), 0.02).turn_rate
        assert left * angle > -1e-3
    assert abs(left) < 1e-2


def test_the_robot_stops_within_the_distance_from_the_speed_that_it_allows():
    for distance in np.linspace(0.0, 3.0, 31):
        ramp, left = VelocitySmoother(SETTINGS), distance
        for _ in range(1500):
            speed = min(braking_speed_limit(left, SETTINGS), SETTINGS.max_linear_velocity)
            left -= 0.02 * ramp.step_toward(Velocity(speed), 0.02).forward
        assert -0.02 < left < 0.05


def test_a_point_behind_is_turned_to_on_the_spot():
    for bearing in (1.5, -3.0):
        velocity = velocity_towards(bearing, 0.5, SETTINGS)
        assert velocity.forward == 0.0
        assert velocity.turn_rate * bearing > 0.0
    assert velocity_towards(0.0, 0.5, SETTINGS) == Velocity(0.5, 0.0)


def test_less_room_means_less_speed_but_never_none():
    speeds = [obstacle_speed_limit(gap, SETTINGS) for gap in np.linspace(-0.1, 1.0, 50)]
    assert (np.diff(speeds) >= 0.0).all()
    assert speeds[0] > 0.0
    assert speeds[-1] == SETTINGS.max_linear_velocity
    fast = replace(SETTINGS, max_linear_velocity=3.0)
    assert obstacle_speed_limit(-0.1, fast) == pytest.approx(0.1)
    assert obstacle_speed_limit(fast.slow_distance, fast) == 3.0
