"""A mission succeeds only if every goal was reached within the limits and without a collision."""

import json
import math

import pytest

from scene_simulator.mission.layout import DARK
from shirube_bringup.record import GoalRecord, MissionRecord, count_collisions
from shirube_core.geometry import SE2

GOOD = GoalRecord(True, 10.0, 0.012, 0.02, 0.008)


def record_of(*goals: GoalRecord, clearances: tuple[float, ...] = (0.5, 0.3)) -> MissionRecord:
    """Return the record of a straight drive through the dark zone."""
    record = MissionRecord(4, list(goals))
    for k, clearance in enumerate(clearances):
        record.add_step(0.5 * k, SE2(6.0 + 0.25 * k, 3.5, 0.1 * k), clearance)
    return record


@pytest.mark.parametrize(
    'bad',
    [
        GoalRecord(False, 90.0, 0.012, 0.02, 0.008),
        GoalRecord(True, 10.0, 0.031, 0.02, 0.008),
        GoalRecord(True, 10.0, 0.012, 0.02, 0.021),
        GoalRecord(True, 10.0, math.nan, 0.02, 0.008),
    ],
)
def test_one_bad_goal_spoils_it(bad):
    assert record_of(GOOD, GOOD, GOOD).has_succeeded(3)
    assert not record_of(GOOD, bad, GOOD).has_succeeded(3)


def test_a_goal_that_is_missing_spoils_it():
    assert not record_of(GOOD, GOOD).has_succeeded(3)


def test_a_touch_spoils_it_and_counts_once_until_it_ends():
    record = record_of(GOOD, clearances=(0.1, 0.0, -0.01, 0.2, -0.02))
    assert count_collisions(record.clearances) == 2
    assert record.summary(1, {'pose_arbiter': []}, [], {})['least_clearance'] == -0.02
    assert not record.has_succeeded(1)


def test_poses_are_compared_with_the_truth_of_their_time_and_counted_by_zone():
    record = record_of(GOOD)
    poses = {'pose_arbiter': [(0.25, 6.125, 3.503, 0.0)], 'vlc_beacon': [(-1.0, 0.0, 0.0, 0.0)]}
    summary = record.summary(1, poses, [(1.0, 'slow 0.2')], {'whole': 3.0})
    assert DARK.contains(6.125, 3.5)
    assert summary['poses']['pose_arbiter']['worst'] == pytest.approx(0.003)
    assert summary['poses']['vlc_beacon'] == {'count': 0}
    assert summary['zones']['dark']['poses'] == {'pose_arbiter': 1, 'vlc_beacon': 0}
    assert summary['zones']['dark']['seconds'] == pytest.approx(0.5)
    assert summary['zones']['carpet']['seconds'] == 0.0
    assert summary['path_length'] == pytest.approx(0.25)
    assert json.loads(json.dumps(summary))['success'] is True
