"""Commands of lamps are in effect until the next ones."""

from __future__ import annotations

import math

import pytest

from reward_planner.core.driving.light_command import LightCommand, LightCommandState


def test_slow_never_makes_faster_and_no_lamp_exceeds_the_limit():
    state = LightCommandState(0.5)
    for operation, value, speed in (
        ('slow', 0.2, 0.2),
        ('slow', 0.4, 0.2),
        ('speed_up', 0.3, 0.3),
        ('speed_up', 9.0, 0.5),
        ('slow', 0.1, 0.1),
        ('resume', 0.0, 0.5),
    ):
        state.apply_command(LightCommand(operation, value))
        assert state.speed_limit == speed


def test_stop_holds_until_resume():
    state = LightCommandState(0.5)
    state.apply_command(LightCommand('stop', 0.0))
    state.apply_command(LightCommand('speed_up', 0.3))
    assert state.is_stopped
    state.apply_command(LightCommand('resume', 0.0))
    assert not state.is_stopped


@pytest.mark.parametrize('angle', [0.5 * math.pi, -1.5 * math.pi, math.tau])
def test_a_turn_counts_down_the_way_it_was_asked_for(angle):
    state = LightCommandState(0.5)
    state.update_heading(3.0)
    state.apply_command(LightCommand('turn', angle))
    for k in range(1, 11):
        state.update_heading(math.remainder(3.0 + 0.1 * k * angle, math.tau))
        assert state.remaining_turn == pytest.approx(angle * (1.0 - 0.1 * k), abs=1e-9)


def test_turns_add_up_to_a_whole_turn_at_most():
    state = LightCommandState(0.5)
    for _ in range(3):
        state.apply_command(LightCommand('turn', math.tau))
    assert state.remaining_turn == math.tau


def test_after_a_jump_of_the_poses_the_heading_is_reset():
    state = LightCommandState(0.5)
    state.update_heading(0.0)
    state.cancel_turn()
    state.apply_command(LightCommand('turn', 1.0))
    state.update_heading(2.0)
    assert state.remaining_turn == 1.0
