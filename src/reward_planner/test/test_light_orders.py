"""Commands of lamps are in effect until the next ones."""

from __future__ import annotations

import math

import pytest

from reward_planner.core.driving.light_command import LightCommand
from reward_planner.core.driving.light_orders import LightOrders


def test_slow_never_makes_faster_and_no_lamp_exceeds_the_limit():
    orders = LightOrders(0.5)
    for operation, value, speed in (
        ('slow', 0.2, 0.2),
        ('slow', 0.4, 0.2),
        ('speed_up', 0.3, 0.3),
        ('speed_up', 9.0, 0.5),
        ('slow', 0.1, 0.1),
        ('resume', 0.0, 0.5),
    ):
        orders.obey(LightCommand(operation, value))
        assert orders.speed == speed


def test_stop_holds_until_resume():
    orders = LightOrders(0.5)
    orders.obey(LightCommand('stop', 0.0))
    orders.obey(LightCommand('speed_up', 0.3))
    assert orders.is_stopped
    orders.obey(LightCommand('resume', 0.0))
    assert not orders.is_stopped


@pytest.mark.parametrize('angle', [0.5 * math.pi, -1.5 * math.pi, math.tau])
def test_a_turn_counts_down_the_way_it_was_asked_for(angle):
    orders = LightOrders(0.5)
    orders.robot_heads(3.0)
    orders.obey(LightCommand('turn', angle))
    for k in range(1, 11):
        orders.robot_heads(math.remainder(3.0 + 0.1 * k * angle, math.tau))
        assert orders.left_to_turn == pytest.approx(angle * (1.0 - 0.1 * k), abs=1e-9)


def test_turns_add_up_to_a_whole_turn_at_most():
    orders = LightOrders(0.5)
    for _ in range(3):
        orders.obey(LightCommand('turn', math.tau))
    assert orders.left_to_turn == math.tau


def test_after_a_jump_of_the_poses_the_heading_counts_anew():
    orders = LightOrders(0.5)
    orders.robot_heads(0.0)
    orders.end_turn()
    orders.obey(LightCommand('turn', 1.0))
    orders.robot_heads(2.0)
    assert orders.left_to_turn == 1.0
