"""A route is kept unless it is blocked or clearly longer than a new one."""

from __future__ import annotations

import numpy as np
import pytest

from reward_planner.core.driving.driving_settings import DrivingSettings
from reward_planner.core.driving.route_keeper import RouteKeeper, length_of
from reward_planner.core.grid.grid_frame import GridFrame
from reward_planner.core.grid.occupancy_map import FREE, OCCUPIED
from reward_planner.core.mapping.global_map import GlobalMap
from reward_planner.core.mapping.local_map import LocalMap
from reward_planner.core.planner_settings import PlannerSettings
from reward_planner.core.reward.reward_settings import RewardSettings
from reward_planner.core.route.route import NoRouteReason
from shirube_geometry import PlanarPose

FRAME = GridFrame(-1.0, -4.0, 0.1, 100, 80)
HERE = PlanarPose(0.0, 0.0, 0.0)
GOAL = (8.0, 0.0)


class Floor:
    """A map that can be painted, and a replanner on it."""

    def __init__(self, mode='optimal'):
        self.known = GlobalMap(0.1, 1_000_000)
        self.paint((-1.0, -4.0, 9.0, 4.0), FREE)
        planner = PlannerSettings(mode, 0.2)
        self.keeper = RouteKeeper(self.known, GOAL, planner, RewardSettings(), DrivingSettings())

    def paint(self, box, value):
        low, high = FRAME.cell_of([box[:2], box[2:]])
        observed = np.zeros(FRAME.shape, dtype=bool)
        observed[low[0] : high[0], low[1] : high[1]] = True
        self.known.write(LocalMap(FRAME, np.full(FRAME.shape, value, dtype=np.int8), observed))
        if hasattr(self, 'keeper'):
            self.keeper.map_changed(FRAME)


def test_a_route_that_nothing_touches_is_kept():
    floor = Floor()
    floor.keeper.update(0.0, HERE)
    for k in range(1, 40):
        floor.paint((2.0 + 0.1 * k, 2.0, 2.1 + 0.1 * k, 2.5), OCCUPIED)
        floor.keeper.update(0.5 * k, HERE)
    assert floor.keeper.plans == 1
    assert length_of(floor.keeper.points_map) == pytest.approx(8.0, abs=0.2)


def test_a_route_that_is_blocked_is_replaced_at_once():
    floor = Floor()
    floor.keeper.update(0.0, HERE)
    floor.paint((4.0, -1.0, 4.5, 1.0), OCCUPIED)
    floor.keeper.update(0.05, HERE)
    assert floor.keeper.plans == 2
    assert np.abs(floor.keeper.points_map[:, 1]).max() > 1.2
    assert floor.keeper.area.clearance_at(floor.keeper.points_map[:-1]).min() > 0.3


def test_a_route_that_is_only_just_beaten_is_kept_and_one_that_is_clearly_beaten_is_left():
    floor = Floor()
    floor.paint((4.0, -4.0, 4.5, 0.6), OCCUPIED)
    floor.keeper.update(0.0, HERE)
    floor.paint((4.0, -1.2, 4.5, -0.2), FREE)  # hardly shorter
    floor.keeper.update(5.0, HERE)
    assert floor.keeper.plans == 1
    floor.paint((4.0, 0.6, 4.5, 3.6), OCCUPIED)
    floor.paint((4.0, -1.2, 4.5, -0.2), OCCUPIED)
    floor.keeper.update(6.0, HERE)
    assert floor.keeper.plans == 2
    floor.paint((4.0, -0.7, 4.5, 0.7), FREE)
    floor.keeper.update(6.2, HERE)
    assert floor.keeper.plans == 2  # not at every tick
    floor.keeper.update(8.0, HERE)
    assert floor.keeper.plans == 3
    assert length_of(floor.keeper.points_map) < 8.5


def test_why_there_is_no_route_is_told_and_a_way_that_opens_is_taken():
    floor = Floor()
    floor.paint((4.0, -4.0, 4.5, 4.0), OCCUPIED)
    floor.paint((-1.0, 3.5, 9.0, 4.0), OCCUPIED)
    floor.paint((-1.0, -4.0, 9.0, -3.5), OCCUPIED)
    floor.paint((-1.0, -4.0, -0.5, 4.0), OCCUPIED)
    floor.keeper.update(0.0, HERE)
    assert floor.keeper.problem is NoRouteReason.UNREACHABLE
    floor.paint((4.0, -1.0, 4.5, 1.0), FREE)
    floor.keeper.update(2.0, HERE)
    assert floor.keeper.problem is None
    assert floor.keeper.plans == 1


def test_a_start_in_a_passage_that_is_too_narrow_is_told():
    floor = Floor()
    floor.paint((-1.0, 0.25, 3.0, 0.5), OCCUPIED)
    floor.paint((-1.0, -0.5, 3.0, -0.25), OCCUPIED)
    floor.keeper.update(0.0, HERE)
    assert floor.keeper.problem is NoRouteReason.START_BLOCKED


def test_the_route_shrinks_as_the_robot_drives_and_a_robot_off_it_gets_another():
    floor = Floor()
    floor.keeper.update(0.0, HERE)
    floor.keeper.update(0.1, PlanarPose(1.0, 0.05, 0.0))
    assert length_of(floor.keeper.points_map) == pytest.approx(7.0, abs=0.2)
    floor.keeper.update(0.2, PlanarPose(1.0, 0.9, 0.0))
    assert floor.keeper.plans == 2


def test_the_reward_rule_decides_a_stretch_at_a_time():
    floor = Floor('reward')
    floor.keeper.update(0.0, HERE)
    assert length_of(floor.keeper.points_map) < 2.0
    x = 0.0
    while x < 8.0:
        x += 0.1
        floor.keeper.update(x, PlanarPose(x, 0.0, 0.0))
    assert floor.keeper.points_map[-1].tolist() == list(GOAL)
