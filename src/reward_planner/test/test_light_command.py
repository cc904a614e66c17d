"""Commands of vlc_beacon are parsed, and malformed ones are rejected in one line."""

from __future__ import annotations

import json

import pytest

from reward_planner.core.driving.light_command import OPERATIONS, LightCommand, parse_light_command
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
