"""Poses are interpolated, but not across jumps or gaps; frames get theirs, or are dropped and counted."""

import math

import numpy as np
import pytest

from reward_planner.core.mapping.pose_buffer import DropReason, PoseBuffer, PoseMessageFilter, PoseStatus
from reward_planner.core.settings import MappingSettings
from shirube_core.geometry import SE2
from shirube_core.motion import NoPoseReason


def drive(buffer, start, end):
    """Poses at 20 Hz of a robot that drives along x at 1 m/s."""
    for k in range(round(20 * start), round(20 * end) + 1):
        assert buffer.add(k / 20.0, SE2(k / 20.0, 2.0, 0.0)) is PoseStatus.ACCEPTED


def driven(until=5.0):
    buffer = PoseBuffer(MappingSettings())
    drive(buffer, 0.0, until)
    return buffer


def test_poses_are_interpolated_but_not_guessed_beyond_them_or_in_a_gap():
    buffer = driven()
    for stamp in np.linspace(0.0, 5.0, 37):
        assert buffer.pose_at(stamp).x == pytest.approx(stamp)
        assert buffer.pose_at(stamp).y == pytest.approx(2.0)
    assert buffer.pose_at(5.01) is NoPoseReason.TOO_NEW
    assert buffer.pose_at(-0.01) is NoPoseReason.TOO_OLD
    buffer.add(5.8, SE2(5.8, 2.0, 0.0))
    assert buffer.pose_at(5.4) is NoPoseReason.GAP
    assert buffer.pose_at(5.8).x == pytest.approx(5.8)
    assert PoseBuffer(MappingSettings()).pose_at(0.0) is NoPoseReason.EMPTY


def test_headings_turn_the_short_way():
    buffer = PoseBuffer(MappingSettings())
    buffer.add(0.0, SE2(0.0, 0.0, math.pi - 0.1))
    buffer.add(0.1, SE2(0.0, 0.0, -math.pi + 0.1))
    assert abs(buffer.pose_at(0.05).yaw) == pytest.approx(math.pi)


@pytest.mark.parametrize('jump', [SE2(5.0, 2.0, 0.0), SE2(1.05, 2.0, 2.0)])
def test_a_pose_that_jumps_is_refused_and_the_next_good_one_taken(jump):
    buffer = driven(1.0)
    assert buffer.add(1.05, jump) is PoseStatus.JUMPED
    assert buffer.has_jumped
    assert buffer.add(1.1, SE2(1.1, 2.0, 0.0)) is PoseStatus.ACCEPTED
    assert not buffer.has_jumped
    assert buffer.pose_at(1.05).x == pytest.approx(1.05)


def test_a_new_place_is_accepted_once_poses_agree_there():
    buffer = driven(1.0)
    statuses = [buffer.add(1.0 + 0.1 * k, SE2(8.0 + 0.1 * k, 2.0, 0.0)) for k in range(1, 13)]
    assert statuses[:10] == [PoseStatus.JUMPED] * 10
    assert statuses[10] is PoseStatus.RELOCATED
    assert statuses[11] is PoseStatus.ACCEPTED
    assert buffer.pose_at(1.5) is NoPoseReason.TOO_OLD
    assert buffer.pose_at(2.15).x == pytest.approx(9.15)


def test_poses_that_jump_all_over_are_never_accepted():
    buffer, rng = driven(1.0), np.random.default_rng(0)
    for k in range(1, 200):
        x, y = rng.uniform(20.0, 400.0, 2)
        assert buffer.add(1.0 + 0.1 * k, SE2(x, y, 0.0)) is PoseStatus.JUMPED
    assert buffer.pose_at(2.0) is NoPoseReason.TOO_NEW


def test_a_pose_that_comes_late_is_reported():
    buffer = driven()
    assert buffer.add(4.9, SE2(4.9, 2.0, 0.0)) is PoseStatus.OUT_OF_ORDER
    assert buffer.add(5.0, SE2(5.0, 2.0, 0.0)) is PoseStatus.OUT_OF_ORDER
    assert buffer.pose_at(4.95).x == pytest.approx(4.95)


@pytest.mark.parametrize('pose', [SE2(math.nan, 0.0, 0.0), SE2(0.0, math.inf, 0.0)])
def test_a_pose_that_is_not_finite_is_reported(pose):
    buffer = driven()
    assert buffer.add(5.1, pose) is PoseStatus.NOT_FINITE
    assert buffer.add(math.nan, SE2(5.0, 2.0, 0.0)) is PoseStatus.NOT_FINITE
    assert buffer.pose_at(5.0).x == pytest.approx(5.0)


def test_old_poses_are_forgotten():
    buffer = driven(30.0)
    assert buffer.pose_at(5.0) is NoPoseReason.TOO_OLD
    assert buffer.pose_at(25.0).x == pytest.approx(25.0)


def test_a_frame_waits_for_the_pose_of_its_instant():
    buffer, frames = driven(1.0), PoseMessageFilter[str](0.5)
    frames.add(1.13, 1.15, 'a')
    assert frames.take_ready(1.2, buffer) == []
    drive(buffer, 1.05, 1.2)
    ((stamp, frame, pose),) = frames.take_ready(1.25, buffer)
    assert (stamp, frame) == (1.13, 'a')
    assert pose.x == pytest.approx(1.13)
    assert len(frames) == 0
    assert not frames.dropped


def test_a_frame_whose_pose_does_not_come_or_is_missing_is_dropped_and_counted():
    buffer, frames = PoseBuffer(MappingSettings()), PoseMessageFilter[str](0.5)
    frames.add(1.0, 1.0, 'a')
    assert frames.take_ready(1.4, buffer) == []
    assert len(frames) == 1
    assert frames.take_ready(1.6, buffer) == []
    assert frames.dropped == {DropReason.POSE_LATE: 1}
    frames.add(100.0, 100.0, 'old')
    assert frames.take_ready(3.0, buffer) == []  # the clock jumped back
    assert frames.dropped == {DropReason.POSE_LATE: 2}
    drive(buffer, 1.0, 2.0)
    frames.add(0.9, 2.0, 'before the first pose')
    assert frames.take_ready(2.0, buffer) == []
    assert frames.dropped[DropReason.POSE_MISSING] == 1


def test_frames_within_a_jump_are_dropped_and_later_ones_taken():
    buffer, frames = driven(1.0), PoseMessageFilter[int](5.0)
    taken = []
    for k in range(8, 32):
        frames.add(0.1 * k, 0.1 * k, k)
        if k > 10:
            for stamp in (0.1 * k - 0.05, 0.1 * k):
                buffer.add(stamp, SE2(30.0 + stamp, 0.0, 0.0))
        taken += frames.take_ready(0.1 * k, buffer)
    assert [frame for _, frame, _ in taken] == [8, 9, 10, *range(21, 32)]
    assert frames.dropped[DropReason.POSE_MISSING] == 10


def test_the_queue_is_bounded():
    frames = PoseMessageFilter[int](1e9)
    for k in range(100):
        frames.add(0.1 * k, 0.1 * k, k)
    assert len(frames) == 32
    assert frames.dropped == {DropReason.QUEUE_FULL: 68}
