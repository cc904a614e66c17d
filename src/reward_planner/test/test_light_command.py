"""Commands of lamps: parsing, and which are in effect."""

import json
import math

import pytest

from reward_planner.core.driving.light_command import OPERATIONS, LightCommand, LightCommandState, parse_light_command
from reward_planner.core.reward_planner_error import DrivingError


@pytest.mark.parametrize('operation', OPERATIONS)
def test_each_operation_is_read(operation):
    text = json.dumps({'beacon': 3, 'counter': 9, 'op': operation, 'value': 0.25})
    assert parse_light_command(text) == LightCommand(operation, 0.25)


@pytest.mark.parametrize(
    ('text', 'words'),
    [
        ('stop', 'not valid JSON'),
        ('[1]', 'an unknown op'),
        ('{"op": "jump"}', 'must be one of stop, resume, slow, speed_up, turn'),
        ('{"op": "slow", "value": "much"}', 'not a number of at most 1000'),
        ('{"op": "turn", "value": NaN}', 'not a number of at most 1000'),
        ('{"op": "turn", "value": true}', 'not a number of at most 1000'),
        ('{"op": "slow", "value": -0.1}', 'negative speed'),
        ('{"op": "slow"}', 'not a number of at most 1000'),
        ('{"op": "turn", "value": 7.0}', 'at most one full turn'),
        ('{"op": "turn", "value": 1e308}', 'not a number of at most 1000'),
        ('{"op": "slow", "value": 1' + 400 * '0' + '}', 'not a number of at most 1000'),
        (100_000 * '[', 'not valid JSON'),
    ],
)
def test_nonsense_is_refused_in_one_line(text, words):
    with pytest.raises(DrivingError, match=words) as refusal:
        parse_light_command(text)
    assert '\n' not in str(refusal.value)


def test_slow_never_makes_faster_no_lamp_exceeds_the_limit_and_stop_holds_until_resume():
    state = LightCommandState(0.5)
    for operation, value, speed, is_stopped in (
        ('slow', 0.2, 0.2, False),
        ('slow', 0.4, 0.2, False),
        ('speed_up', 0.3, 0.3, False),
        ('speed_up', 9.0, 0.5, False),
        ('slow', 0.1, 0.1, False),
        ('resume', 0.0, 0.5, False),
        ('stop', 0.0, 0.5, True),
        ('speed_up', 0.3, 0.3, True),
        ('resume', 0.0, 0.5, False),
    ):
        state.apply_command(LightCommand(operation, value))
        assert (state.speed_limit, state.is_stopped) == (speed, is_stopped)


@pytest.mark.parametrize('angle', [0.5 * math.pi, -1.5 * math.pi, math.tau])
def test_a_turn_counts_down_the_way_it_was_asked_for(angle):
    state = LightCommandState(0.5)
    state.update_heading(3.0)
    state.apply_command(LightCommand('turn', angle))
    for k in range(1, 11):
        state.update_heading(math.remainder(3.0 + 0.1 * k * angle, math.tau))
        assert state.remaining_turn == pytest.approx(angle * (1.0 - 0.1 * k), abs=1e-9)


def test_turns_add_up_to_a_whole_turn_at_most_and_a_jump_of_the_poses_cancels_them():
    state = LightCommandState(0.5)
    state.update_heading(0.0)
    for _ in range(3):
        state.apply_command(LightCommand('turn', math.tau))
    assert state.remaining_turn == math.tau
    state.cancel_turn()
    state.apply_command(LightCommand('turn', 1.0))
    state.update_heading(2.0)
    assert state.remaining_turn == 1.0
