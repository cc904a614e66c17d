"""Odometry in any order of arrival, and the covariance of its motions."""

from __future__ import annotations

import math

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from short_drive import BEGIN, SECOND, odometry_pose

from pose_arbiter.core.arbiter_settings import ArbiterSettings
from pose_arbiter.core.odometry_mark import motion_between
from pose_arbiter.core.odometry_trail import OdometryTrail
from shirube_geometry import PlanarPose

STAMPS = [BEGIN + k * SECOND // 50 for k in range(60)]


def trail_of(order=range(60), pose_at=odometry_pose):
    trail = OdometryTrail(ArbiterSettings())
    for k in order:
        trail.add(STAMPS[k], pose_at((STAMPS[k] - BEGIN) / SECOND))
    return trail


@given(st.permutations(range(60)), st.integers(-SECOND, 3 * SECOND))
@settings(max_examples=30, deadline=None)
def test_the_order_of_arrival_does_not_matter(order, ahead):
    assert trail_of(order).mark_at(BEGIN + ahead) == trail_of().mark_at(BEGIN + ahead)


@pytest.mark.parametrize(('first', 'last'), [(0.0, 1.0), (0.113, 0.977), (0.5, 0.501)])
def test_a_motion_is_that_of_the_wheels(first, last):
    trail = trail_of()
    a, b = (trail.mark_at(BEGIN + round(s * SECOND)) for s in (first, last))
    motion = motion_between(a, b)
    true = odometry_pose(first).inverse() @ odometry_pose(last)
    moved = PlanarPose(0.0, 0.0, -a.yaw) @ PlanarPose(motion.x, motion.y, motion.yaw + a.yaw)
    assert (moved.x, moved.y, motion.yaw) == pytest.approx((true.x, true.y, true.yaw), abs=1e-5)


def test_the_covariance_is_that_of_the_steps_one_by_one():
    trail, given_ = trail_of(), ArbiterSettings()
    marks = [trail.mark_at(stamp) for stamp in STAMPS]
    total = np.zeros((3, 3))
    for a, b in zip(marks, marks[1:]):
        F = np.eye(3)
        F[0, 2], F[1, 2] = -(b.y - a.y), b.x - a.x
        way, turn = b.way - a.way, b.turn - a.turn
        step = np.diag([given_.way_noise**2 * way] * 2 + [given_.turn_noise**2 * (way + turn)])
        total = F @ total @ F.T + step
    xx, xy, xt, yy, yt, tt = motion_between(marks[0], marks[-1]).covariance
    np.testing.assert_allclose([[xx, xy, xt], [xy, yy, yt], [xt, yt, tt]], total, atol=1e-12)


def test_wheels_that_jump_are_taken_for_blind_and_not_for_motion():
    def restarted(seconds):
        return odometry_pose(seconds) if seconds < 0.5 else PlanarPose(0.3 * (seconds - 0.5), 0.0, 0.0)

    trail = trail_of(pose_at=restarted)
    motion = motion_between(trail.mark_at(STAMPS[24]), trail.mark_at(STAMPS[25]))
    assert (motion.x, motion.y, motion.yaw) == (0.0, 0.0, 0.0)
    assert motion.blind == pytest.approx(0.02)
    assert trail.odometry_at(STAMPS[25]).distance_to(restarted(0.5)) < 1e-9
    assert trail.odometry_at(STAMPS[24] + 1).distance_to(restarted(0.48)) < 1e-3


def test_odometry_that_begins_again_after_a_silence_may_have_missed_what_was_driven():
    missing = range(20, 50)  # 0.6 s
    trail = trail_of([k for k in range(60) if k not in missing], lambda _: PlanarPose(1.0, 2.0, 0.5))
    motion = motion_between(trail.mark_at(STAMPS[10]), trail.mark_at(STAMPS[55]))
    assert motion.way == 0.0
    assert 0.3 < motion.blind < 0.62
    whole = trail_of(pose_at=lambda _: PlanarPose(1.0, 2.0, 0.5))
    assert motion_between(whole.mark_at(STAMPS[10]), whole.mark_at(STAMPS[55])).blind == 0.0


def test_the_robot_goes_on_for_a_moment_and_then_nothing_is_known():
    trail = trail_of()
    a, b, c = (trail.mark_at(STAMPS[-1] + round(s * SECOND)) for s in (0.0, 0.1, 5.0))
    assert math.hypot(b.x - a.x, b.y - a.y) == pytest.approx(0.0408, abs=1e-3)
    assert motion_between(a, b).blind == 0.0
    assert motion_between(a, c).blind == pytest.approx(4.75)


def test_a_stamp_that_is_there_is_left_out():
    trail = trail_of()
    before = trail.mark_at(STAMPS[-1])
    assert trail.add(STAMPS[30], PlanarPose(9.0, 9.0, 0.0)) is None
    assert trail.mark_at(STAMPS[-1]) == before


def test_dropping_the_past_does_not_change_the_present():
    trail, whole = OdometryTrail(ArbiterSettings()), OdometryTrail(ArbiterSettings())
    for k in range(2000):
        stamp = BEGIN + k * SECOND // 100
        for each in (trail, whole):
            each.add(stamp, odometry_pose(k / 100))
        trail.drop_before(stamp - SECOND)
    assert len(trail._stamps) < 500
    at = BEGIN + 19 * SECOND + 555
    assert trail.mark_at(at) == whole.mark_at(at)
