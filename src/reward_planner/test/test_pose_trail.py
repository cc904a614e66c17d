"""Poses are interpolated, but not across jumps or gaps; invalid stamps are reported."""

from __future__ import annotations

import math

import numpy as np
import pytest

from reward_planner.core.mapping.mapping_settings import MappingSettings
from reward_planner.core.mapping.pose_trail import NoPose, PoseTrail, PoseVerdict
from shirube_geometry import PlanarPose


def driven(until=5.0, rate=20.0):
    """A pose buffer of a robot that drives along x at 1 m/s."""
    trail = PoseTrail(MappingSettings())
    for k in range(int(until * rate) + 1):
        assert trail.add(k / rate, PlanarPose(k / rate, 2.0, 0.0)) is PoseVerdict.TAKEN
    return trail


def test_a_pose_between_two_poses_lies_between_them():
    trail = driven()
    for stamp in np.linspace(0.0, 5.0, 37):
        assert trail.at(stamp).x == pytest.approx(stamp)
        assert trail.at(stamp).y == pytest.approx(2.0)


def test_headings_turn_the_short_way():
    trail = PoseTrail(MappingSettings())
    trail.add(0.0, PlanarPose(0.0, 0.0, math.pi - 0.1))
    trail.add(0.1, PlanarPose(0.0, 0.0, -math.pi + 0.1))
    assert abs(trail.at(0.05).yaw) == pytest.approx(math.pi)


def test_a_frame_newer_than_all_poses_waits_and_an_older_one_does_not():
    trail = driven()
    assert trail.at(5.01) is NoPose.NOT_YET
    assert trail.at(-0.01) is NoPose.MISSING
    assert PoseTrail(MappingSettings()).at(0.0) is NoPose.NOT_YET


def test_no_pose_is_guessed_in_a_gap():
    trail = driven(1.0)
    trail.add(1.8, PlanarPose(1.8, 2.0, 0.0))
    assert trail.at(1.4) is NoPose.MISSING
    assert trail.at(1.8).x == pytest.approx(1.8)


def test_a_pose_that_jumps_is_refused_and_the_next_good_one_taken():
    trail = driven(1.0)
    assert trail.add(1.05, PlanarPose(5.0, 2.0, 0.0)) is PoseVerdict.JUMPED
    assert trail.has_jumped
    assert trail.add(1.1, PlanarPose(1.1, 2.0, 0.0)) is PoseVerdict.TAKEN
    assert not trail.has_jumped
    assert trail.at(1.05).x == pytest.approx(1.05)


def test_a_turn_that_no_robot_makes_is_a_jump():
    assert driven(1.0).add(1.05, PlanarPose(1.05, 2.0, 2.0)) is PoseVerdict.JUMPED


def test_a_new_place_is_believed_once_poses_agree_there():
    trail = driven(1.0)
    verdicts = [trail.add(1.0 + 0.1 * k, PlanarPose(8.0 + 0.1 * k, 2.0, 0.0)) for k in range(1, 13)]
    assert verdicts[:10] == [PoseVerdict.JUMPED] * 10
    assert verdicts[10] is PoseVerdict.RELOCATED
    assert verdicts[11] is PoseVerdict.TAKEN
    assert trail.at(1.5) is NoPose.MISSING
    assert trail.at(2.15).x == pytest.approx(9.15)


def test_poses_that_jump_all_over_are_never_believed():
    trail, rng = driven(1.0), np.random.default_rng(0)
    for k in range(1, 200):
        x, y = rng.uniform(20.0, 400.0, 2)
        assert trail.add(1.0 + 0.1 * k, PlanarPose(x, y, 0.0)) is PoseVerdict.JUMPED
    assert trail.at(2.0) is NoPose.NOT_YET


def test_a_pose_that_comes_late_is_told():
    trail = driven()
    assert trail.add(4.9, PlanarPose(4.9, 2.0, 0.0)) is PoseVerdict.OUT_OF_ORDER
    assert trail.add(5.0, PlanarPose(5.0, 2.0, 0.0)) is PoseVerdict.OUT_OF_ORDER
    assert trail.at(4.95).x == pytest.approx(4.95)


@pytest.mark.parametrize('pose', [PlanarPose(math.nan, 0.0, 0.0), PlanarPose(0.0, math.inf, 0.0)])
def test_a_pose_that_is_not_finite_is_told(pose):
    trail = driven()
    assert trail.add(5.1, pose) is PoseVerdict.NOT_FINITE
    assert trail.add(math.nan, PlanarPose(5.0, 2.0, 0.0)) is PoseVerdict.NOT_FINITE
    assert trail.at(5.0).x == pytest.approx(5.0)


def test_old_poses_are_forgotten():
    trail = driven(30.0)
    assert trail.at(5.0) is NoPose.MISSING
    assert trail.at(25.0).x == pytest.approx(25.0)
