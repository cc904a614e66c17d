"""Odometry in any order of arrival, and the covariance of its motions."""

from __future__ import annotations

import math

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from short_drive import BEGIN, SECOND, odometry_pose

from pose_arbiter.core.arbiter_settings import ArbiterSettings
from pose_arbiter.core.cumulative_odometry import motion_between
from pose_arbiter.core.odometry_buffer import OdometryBuffer
from shirube_core.geometry import SE2

STAMPS = [BEGIN + k * SECOND // 50 for k in range(60)]


def buffer_of(order=range(60), pose_at=odometry_pose):
    buffer = OdometryBuffer(ArbiterSettings())
    for k in order:
        buffer.add(STAMPS[k], pose_at((STAMPS[k] - BEGIN) / SECOND))
    return buffer


@given(st.permutations(range(60)), st.integers(-SECOND, 3 * SECOND))
@settings(max_examples=30, deadline=None)
def test_the_order_of_arrival_does_not_matter(order, ahead):
    assert buffer_of(order).lookup(BEGIN + ahead) == buffer_of().lookup(BEGIN + ahead)


@pytest.mark.parametrize(('first', 'last'), [(0.0, 1.0), (0.113, 0.977), (0.5, 0.501)])
def test_a_motion_is_that_of_the_wheels(first, last):
    buffer = buffer_of()
    a, b = (buffer.lookup(BEGIN + round(s * SECOND)) for s in (first, last))
    motion = motion_between(a, b)
    true = odometry_pose(first).inverse() @ odometry_pose(last)
    path_length = SE2(0.0, 0.0, -a.yaw) @ SE2(motion.x, motion.y, motion.yaw + a.yaw)
    assert (path_length.x, path_length.y, motion.yaw) == pytest.approx((true.x, true.y, true.yaw), abs=1e-5)


def test_the_covariance_is_that_of_the_steps_one_by_one():
    buffer, noise_settings = buffer_of(), ArbiterSettings()
    cumulative = [buffer.lookup(stamp) for stamp in STAMPS]
    total = np.zeros((3, 3))
    for a, b in zip(cumulative, cumulative[1:]):
        F = np.eye(3)
        F[0, 2], F[1, 2] = -(b.y - a.y), b.x - a.x
        distance, rotation = b.distance - a.distance, b.rotation - a.rotation
        step = np.diag(
            [noise_settings.odometry_noise_xy**2 * distance] * 2
            + [noise_settings.odometry_noise_yaw**2 * (distance + rotation)]
        )
        total = F @ total @ F.T + step
    xx, xy, xt, yy, yt, tt = motion_between(cumulative[0], cumulative[-1]).covariance
    np.testing.assert_allclose([[xx, xy, xt], [xy, yy, yt], [xt, yt, tt]], total, atol=1e-12)


def test_a_jump_of_odometry_is_a_gap_and_not_motion():
    def restarted(seconds):
        return odometry_pose(seconds) if seconds < 0.5 else SE2(0.3 * (seconds - 0.5), 0.0, 0.0)

    buffer = buffer_of(pose_at=restarted)
    motion = motion_between(buffer.lookup(STAMPS[24]), buffer.lookup(STAMPS[25]))
    assert (motion.x, motion.y, motion.yaw) == (0.0, 0.0, 0.0)
    assert motion.odometry_gap == pytest.approx(0.02)
    assert buffer.pose_at(STAMPS[25]).distance_to(restarted(0.5)) < 1e-9
    assert buffer.pose_at(STAMPS[24] + 1).distance_to(restarted(0.48)) < 1e-3


def test_odometry_that_begins_again_after_a_silence_may_have_missed_what_was_driven():
    missing = range(20, 50)  # 0.6 s
    buffer = buffer_of([k for k in range(60) if k not in missing], lambda _: SE2(1.0, 2.0, 0.5))
    motion = motion_between(buffer.lookup(STAMPS[10]), buffer.lookup(STAMPS[55]))
    assert motion.distance == 0.0
    assert 0.3 < motion.odometry_gap < 0.62
    whole = buffer_of(pose_at=lambda _: SE2(1.0, 2.0, 0.5))
    assert motion_between(whole.lookup(STAMPS[10]), whole.lookup(STAMPS[55])).odometry_gap == 0.0


def test_the_robot_goes_on_for_a_moment_and_then_nothing_is_known():
    buffer = buffer_of()
    a, b, c = (buffer.lookup(STAMPS[-1] + round(s * SECOND)) for s in (0.0, 0.1, 5.0))
    assert math.hypot(b.x - a.x, b.y - a.y) == pytest.approx(0.0408, abs=1e-3)
    assert motion_between(a, b).odometry_gap == 0.0
    assert motion_between(a, c).odometry_gap == pytest.approx(4.75)


def test_a_stamp_that_is_there_is_left_out():
    buffer = buffer_of()
    before = buffer.lookup(STAMPS[-1])
    assert buffer.add(STAMPS[30], SE2(9.0, 9.0, 0.0)) is None
    assert buffer.lookup(STAMPS[-1]) == before


def test_dropping_the_past_does_not_change_the_present():
    buffer, whole = OdometryBuffer(ArbiterSettings()), OdometryBuffer(ArbiterSettings())
    for k in range(2000):
        stamp = BEGIN + k * SECOND // 100
        for each in (buffer, whole):
            each.add(stamp, odometry_pose(k / 100))
        buffer.drop_before(stamp - SECOND)
    assert len(buffer._stamps) < 500
    at = BEGIN + 19 * SECOND + 555
    assert buffer.lookup(at) == whole.lookup(at)
