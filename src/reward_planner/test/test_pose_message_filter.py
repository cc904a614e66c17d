"""Frames get the pose at their stamp, or are dropped and counted with the reason."""

from __future__ import annotations

import pytest

from reward_planner.core.mapping.mapping_settings import MappingSettings
from reward_planner.core.mapping.pose_buffer import PoseBuffer
from reward_planner.core.mapping.pose_message_filter import DropReason, PoseMessageFilter
from shirube_core.geometry import SE2


def drive(buffer, start, end):
    """Poses at 20 Hz of a robot that drives along x at 1 m/s."""
    for k in range(round(20 * start), round(20 * end) + 1):
        buffer.add(k / 20.0, SE2(k / 20.0, 0.0, 0.0))


def test_a_frame_waits_for_the_pose_of_its_instant():
    buffer, frames = PoseBuffer(MappingSettings()), PoseMessageFilter[str](0.5)
    drive(buffer, 0.0, 1.0)
    frames.add(1.13, 1.15, 'a')
    assert frames.take_ready(1.2, buffer) == []
    drive(buffer, 1.05, 1.2)
    ((stamp, frame, pose),) = frames.take_ready(1.25, buffer)
    assert (stamp, frame) == (1.13, 'a')
    assert pose.x == pytest.approx(1.13)
    assert len(frames) == 0
    assert not frames.dropped


def test_a_frame_whose_pose_does_not_come_is_dropped_and_counted():
    buffer, frames = PoseBuffer(MappingSettings()), PoseMessageFilter[str](0.5)
    frames.add(1.0, 1.0, 'a')
    assert frames.take_ready(1.4, buffer) == []
    assert len(frames) == 1
    assert frames.take_ready(1.6, buffer) == []
    assert frames.dropped == {DropReason.POSE_LATE: 1}


def test_a_frame_from_before_the_first_pose_is_dropped_at_once():
    buffer, frames = PoseBuffer(MappingSettings()), PoseMessageFilter[str](0.5)
    drive(buffer, 1.0, 2.0)
    frames.add(0.9, 2.0, 'a')
    assert frames.take_ready(2.0, buffer) == []
    assert frames.dropped == {DropReason.POSE_MISSING: 1}


def test_frames_within_a_jump_are_dropped_and_later_ones_taken():
    buffer, frames = PoseBuffer(MappingSettings()), PoseMessageFilter[int](5.0)
    drive(buffer, 0.0, 1.0)
    taken = []
    for k in range(8, 32):
        frames.add(0.1 * k, 0.1 * k, k)
        if k > 10:
            for stamp in (0.1 * k - 0.05, 0.1 * k):
                buffer.add(stamp, SE2(30.0 + stamp, 0.0, 0.0))
        taken += frames.take_ready(0.1 * k, buffer)
    assert [frame for _, frame, _ in taken] == [8, 9, 10, *range(21, 32)]
    assert frames.dropped[DropReason.POSE_MISSING] == 10


def test_frames_come_out_in_the_order_in_which_they_came():
    buffer, frames = PoseBuffer(MappingSettings()), PoseMessageFilter[int](0.5)
    drive(buffer, 0.0, 2.0)
    for k in range(10):
        frames.add(0.1 * k, 1.0, k)
    assert [frame for _, frame, _ in frames.take_ready(1.1, buffer)] == list(range(10))


def test_the_queue_is_bounded():
    frames = PoseMessageFilter[int](1e9)
    for k in range(100):
        frames.add(0.1 * k, 0.1 * k, k)
    assert len(frames) == 32
    assert frames.dropped == {DropReason.QUEUE_FULL: 68}


def test_a_clock_that_jumps_back_keeps_no_frame_for_ever():
    buffer, frames = PoseBuffer(MappingSettings()), PoseMessageFilter[str](0.5)
    frames.add(100.0, 100.0, 'old')
    assert frames.take_ready(3.0, buffer) == []
    assert frames.dropped == {DropReason.POSE_LATE: 1}
